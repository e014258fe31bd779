#include "tests/server/cli/child_program.h"
#include "tests/support/paths.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <vector>

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;

fs::path MakeFolder() {
  std::string pattern = (fs::temp_directory_path() / "faultlab-cli-XXXXXX").string();
  return ::mkdtemp(pattern.data());
}

std::string Slurp(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace

ChildProgram::ChildProgram() : folder_(MakeFolder()), streams_(MakeFolder()) {}

ChildProgram::~ChildProgram() {
  fs::remove_all(folder_);
  fs::remove_all(streams_);
}

Finished ChildProgram::Run(const std::string& arguments, const std::string& before) const {
  const fs::path out = streams_ / "out";
  const fs::path err = streams_ / "err";
  const bool redirected = arguments.find('>') != std::string::npos;
  const std::string command =
      "cd '" + folder_.string() + "' && " + before + " '" + tests::Program() + "' " + arguments +
      (redirected ? "" : " >'" + out.string() + "'") + " 2>'" + err.string() + "'";
  const int status = std::system(command.c_str());
  Finished finished;
  finished.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  finished.out = redirected ? "" : Slurp(out);
  finished.err = Slurp(err);
  return finished;
}

void ChildProgram::Write(const std::string& name, const std::string& text) const {
  fs::create_directories((folder_ / name).parent_path());
  std::ofstream(folder_ / name, std::ios::binary) << text;
}

std::string ChildProgram::Read(const std::string& name) const {
  return Slurp(folder_ / name);
}

bool ChildProgram::Exists(const std::string& name) const {
  return fs::exists(folder_ / name);
}

std::string ChildProgram::Listing() const {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  std::string text;
  for (const std::string& name : names) {
    text += (text.empty() ? "" : " ") + name;
  }
  return text;
}

}  // namespace faultlab::server
