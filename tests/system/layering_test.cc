// The allowed arrows between folders, held by reading every #include (design: web -> server ->
// hardware -> core -> Eigen and std; inside core types <- signals, plant, estimators <- diagnosis
// <- validation).
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Include {
  std::string file;
  int line;
  std::string target;  ///< as written, without <> or ""
};

const fs::path kRoot = FAULTLAB_SOURCE_DIR;

/// Every #include of the sources under `folder` (relative to the repository).
std::vector<Include> IncludesUnder(const std::string& folder) {
  static const std::regex kPattern(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  std::vector<Include> includes;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / folder)) {
    const std::string extension = entry.path().extension().string();
    if (!entry.is_regular_file() || (extension != ".h" && extension != ".cc")) {
      continue;
    }
    std::ifstream file(entry.path());
    std::string text;
    for (int line = 1; std::getline(file, text); ++line) {
      std::smatch match;
      if (std::regex_search(text, match, kPattern)) {
        includes.push_back({fs::relative(entry.path(), kRoot).string(), line, match[1].str()});
      }
    }
  }
  return includes;
}

bool StartsWith(const std::string& text, const std::string& head) {
  return text.compare(0, head.size(), head) == 0;
}

std::string Where(const Include& include) {
  return include.file + ":" + std::to_string(include.line) + " includes " + include.target;
}

TEST(Layering, CoreFoldersPointOnlyDownwards) {
  const std::map<std::string, std::set<std::string>> allowed = {
      {"types", {"types"}},
      {"signals", {"types", "signals"}},
      {"plant", {"types", "signals", "plant"}},
      {"estimators", {"types", "signals", "estimators"}},
      {"diagnosis", {"types", "signals", "plant", "estimators", "diagnosis"}},
      {"validation", {"types", "signals", "plant", "estimators", "diagnosis", "validation"}}};
  for (const auto& [folder, targets] : allowed) {
    int seen = 0;
    for (const Include& include : IncludesUnder("core/" + folder)) {
      if (!StartsWith(include.target, "core/")) {
        continue;
      }
      ++seen;
      const std::string rest = include.target.substr(5);
      EXPECT_TRUE(targets.contains(rest.substr(0, rest.find('/')))) << Where(include);
    }
    EXPECT_GT(seen, 0) << "nothing read under core/" << folder;
  }
}

TEST(Layering, CoreKnowsNoClockThreadFileSocketJsonOrLog) {
  const std::set<std::string> forbidden = {
      "thread",      "mutex",  "shared_mutex", "condition_variable", "future",
      "semaphore",   "latch",  "barrier",      "stop_token",         "chrono",
      "ctime",       "time.h", "fstream",      "iostream",           "filesystem",
      "unistd.h",    "random", "pthread.h",    "syncstream",         "sys/time.h",
      "sys/socket.h"};
  const std::vector<std::string> heads = {
      "boost/", "spdlog/", "soci", "lcm/", "opencv2/", "toml", "CLI", "sodium", "sys/"};
  const std::vector<Include> includes = IncludesUnder("core");
  EXPECT_GT(includes.size(), 50U);
  for (const Include& include : includes) {
    EXPECT_FALSE(forbidden.contains(include.target)) << Where(include);
    for (const std::string& head : heads) {
      EXPECT_FALSE(StartsWith(include.target, head)) << Where(include);
    }
    if (include.target.find('/') != std::string::npos) {
      EXPECT_TRUE(StartsWith(include.target, "core/") || StartsWith(include.target, "Eigen/"))
          << Where(include);
    }
  }
}

TEST(Layering, HardwarePointsAtCoreAndItselfAlone) {
  for (const Include& include : IncludesUnder("hardware")) {
    EXPECT_FALSE(StartsWith(include.target, "server/")) << Where(include);
    EXPECT_FALSE(StartsWith(include.target, "web/")) << Where(include);
    EXPECT_FALSE(StartsWith(include.target, "tests/")) << Where(include);
  }
}

TEST(Layering, OnlyHardwareIncludesLcm) {
  for (const std::string folder : {"core", "server"}) {
    for (const Include& include : IncludesUnder(folder)) {
      EXPECT_FALSE(StartsWith(include.target, "lcm/")) << Where(include);
    }
  }
}

TEST(Layering, NothingOfTheProductPointsAtItsTests) {
  for (const std::string folder : {"core", "hardware", "server"}) {
    for (const Include& include : IncludesUnder(folder)) {
      EXPECT_FALSE(StartsWith(include.target, "tests/")) << Where(include);
      EXPECT_FALSE(StartsWith(include.target, "gtest/")) << Where(include);
      EXPECT_FALSE(StartsWith(include.target, "../")) << Where(include);
    }
  }
}

/// Calls that core's sources must not hold, however they came in (Random::Random is our own).
TEST(Layering, CoreInvertsNoMatrixDrawsNoUnseededNumberAndPrintsNothing) {
  const std::regex pattern(
      R"(\.inverse\(\)|[^m]::Random\(|std::rand\b|::now\(\)|\bf?(open|printf|puts)\()");
  int lines = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / "core")) {
    const std::string extension = entry.path().extension().string();
    if (!entry.is_regular_file() || (extension != ".h" && extension != ".cc")) {
      continue;
    }
    std::ifstream file(entry.path());
    std::string text;
    for (int line = 1; std::getline(file, text); ++line) {
      ++lines;
      const std::string code = text.substr(0, text.find("//"));
      EXPECT_FALSE(std::regex_search(code, pattern))
          << fs::relative(entry.path(), kRoot).string() << ":" << line << ": " << text;
    }
  }
  EXPECT_GT(lines, 1000);
}

}  // namespace
