#include "tests/system/members/member_process.h"
#include "tests/support/paths.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace faultlab::tests {

MemberProcess::MemberProcess(const std::string& folder,
                             const std::string& id,
                             const std::string& database_url,
                             const std::string& settings) {
  const std::string file = folder + "/" + id + ".toml";
  const std::string log = folder + "/" + id + ".log";
  std::ofstream(file) << "listen = \"127.0.0.1:0\"\nserver_id = \"" << id << "\"\ndata_dir = \""
                      << folder << "/" << id << "\"\n"
                      << settings << "\n[database]\nurl = \"" << database_url << "\"\n";
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw std::runtime_error("pipe failed");
  const pid_t parent = getpid();
  const std::string program = tests::Program();
  process_ = fork();
  if (process_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(126);
    dup2(ends[1], STDOUT_FILENO);
    dup2(open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644), STDERR_FILENO);
    close(ends[0]);
    execl(program.c_str(), program.c_str(), "serve", "--config", file.c_str(), nullptr);
    _exit(127);
  }
  close(ends[1]);
  // Reads "faultlab listening on http://127.0.0.1:40123"; if the server fails, the pipe ends
  // without it.
  std::FILE* said = fdopen(ends[0], "r");
  std::array<char, 200> line{};
  const bool listens = std::fgets(line.data(), line.size(), said) != nullptr;
  std::fclose(said);
  const std::string text(line.data());
  if (listens) port_ = std::atoi(text.substr(text.rfind(':') + 1).c_str());
  if (port_ == 0) {
    End(SIGKILL);
    throw std::runtime_error("server '" + id + "' does not start, see " + log);
  }
}

MemberProcess::~MemberProcess() {
  End(SIGTERM);
}

void MemberProcess::Freeze() {
  kill(process_, SIGSTOP);
}

void MemberProcess::Wake() {
  kill(process_, SIGCONT);
}

void MemberProcess::Kill() {
  End(SIGKILL);
}

void MemberProcess::End(int signal) {
  if (process_ < 0) return;
  kill(process_, signal);
  waitpid(process_, nullptr, 0);
  process_ = -1;
}

}  // namespace faultlab::tests
