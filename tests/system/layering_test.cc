#include "tests/support/paths.h"
// Checks the allowed arrows between folders by reading every #include: web -> server -> hardware ->
// core -> Eigen and std. Inside core and inside server a table lists the allowed includes.
#include <gmock/gmock.h>
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

const fs::path kRoot = faultlab::tests::InSource("");

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
      const std::size_t first = text.find_first_not_of(" \t");
      if (first == std::string::npos || text[first] != '#') continue;  // a regex takes long
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

bool ContainsAny(const std::string& text, const std::vector<std::string>& parts) {
  return std::any_of(parts.begin(), parts.end(), [&](const std::string& part) {
    return text.find(part) != std::string::npos;
  });
}

std::string Where(const Include& include) {
  return include.file + ":" + std::to_string(include.line) + " includes " + include.target;
}

/// Folder -> the other folders of the same tree that it may include.
using Arrows = std::map<std::string, std::set<std::string>>;

const Arrows kCore = {
    {"types", {}},
    {"numerics", {}},
    {"signals", {"types"}},
    {"estimators", {"types", "numerics"}},
    {"structures", {"types"}},
    {"bench", {"types"}},
    {"fingerprint", {"types"}},
    {"filter", {"types", "numerics"}},
    {"plant", {"types", "numerics", "bench", "signals"}},
    {"detection", {"types", "bench", "filter"}},
    {"isolability", {"types", "bench", "numerics", "filter"}},
    {"calibration", {"types", "numerics", "bench", "filter", "detection"}},
    {"isolation", {"types", "bench", "numerics", "filter"}},
    {"paper", {"types", "structures", "bench", "numerics", "estimators", "plant"}},
    {"diagnosis",
     {"types",
      "bench",
      "estimators",
      "plant",
      "filter",
      "detection",
      "calibration",
      "isolation",
      "paper"}},
    {"control", {"types", "bench", "signals"}},
    {"control/closed_loop",
     {"types", "bench", "signals", "plant", "filter", "isolation", "diagnosis", "control"}},
    {"methods",
     {"types",
      "bench",
      "numerics",
      "signals",
      "estimators",
      "plant",
      "filter",
      "calibration",
      "isolation",
      "paper",
      "diagnosis"}},
    {"paper/reproduction",
     {"types", "bench", "signals", "estimators", "plant", "paper", "diagnosis"}},
};

/// Every folder may include the headers of `server` itself, such as clock.h. A folder inside a
/// folder is separate if it is listed here.
const Arrows kServer = {
    {"csv", {}},
    {"json", {}},
    {"net", {}},
    {"web_client", {}},
    {"oidc", {"web_client"}},
    {"plots", {"json"}},
    {"report", {"plots", "story"}},
    {"demonstration", {}},
    {"methods", {"json", "plots"}},
    {"storage", {}},
    {"camera", {"storage", "web_client"}},
    {"diagnosis_json", {"json"}},
    {"export", {"csv"}},
    {"stream", {"net"}},
    {"auth", {"storage"}},
    {"lab", {"storage"}},
    {"jobs", {"storage"}},
    {"fault_sets", {"storage"}},
    {"idempotency", {"storage"}},
    {"privacy", {"lab", "storage"}},
    {"notify", {"lab", "storage", "web_client"}},
    {"lti", {"course", "notify", "oidc", "storage", "web_client"}},
    {"mail", {"auth", "notify", "storage"}},
    {"story", {"diagnosis_json", "json", "storage"}},
    {"run", {"diagnosis_json", "json", "lab", "storage", "story", "stream"}},
    {"experiment",
     {"auth",
      "diagnosis_json",
      "fault_sets",
      "jobs",
      "json",
      "lab",
      "methods",
      "plots",
      "run",
      "storage",
      "story"}},
    {"upkeep", {"experiment", "lab", "run", "storage"}},
    {"course", {"auth", "diagnosis_json", "experiment", "json", "run", "storage"}},
    {"api", {"auth",       "camera", "course",     "csv",         "demonstration", "diagnosis_json",
             "experiment", "export", "fault_sets", "idempotency", "jobs",          "json",
             "lab",        "lti",    "mail",       "methods",     "net",           "notify",
             "oidc",       "plots",  "report",     "run",         "storage",       "story",
             "stream",     "upkeep"}},
    {"app", {"api",        "auth",       "camera", "config.h", "course",  "diagnosis_json",
             "experiment", "fault_sets", "jobs",   "lab",      "lti",     "mail",
             "net",        "notify",     "oidc",   "plots",    "privacy", "run",
             "storage",    "stream",     "upkeep"}},
    {"cli",
     {"api",
      "app",
      "auth",
      "csv",
      "diagnosis_json",
      "experiment",
      "json",
      "lab",
      "methods",
      "plots",
      "privacy",
      "run",
      "storage"}},
};

/// The longest entry of `arrows` that contains `path` (relative to the tree); otherwise the first
/// part of the path.
std::string FolderOf(const Arrows& arrows, const std::string& path) {
  std::string folder = path.substr(0, path.find('/'));
  for (const auto& [name, targets] : arrows) {
    if (StartsWith(path, name + "/") && name.size() > folder.size()) folder = name;
  }
  return folder;
}

/// Every include inside `tree` that no arrow allows, and every folder without an entry.
std::vector<std::string> Breaches(const std::string& tree,
                                  const Arrows& arrows,
                                  const std::set<std::string>& everybodys,
                                  const std::vector<Include>& includes) {
  std::vector<std::string> breaches;
  for (const Include& include : includes) {
    const std::string from = include.file.substr(tree.size() + 1);
    if (from.find('/') == std::string::npos) continue;  // the tree's own files, main.cc
    const std::string folder = FolderOf(arrows, from);
    const auto allowed = arrows.find(folder);
    if (allowed == arrows.end()) {
      breaches.push_back(tree + "/" + folder + " has no arrows in this test");
      continue;
    }
    if (!StartsWith(include.target, tree + "/")) continue;
    const std::string target = FolderOf(arrows, include.target.substr(tree.size() + 1));
    if (target != folder && !everybodys.contains(target) && !allowed->second.contains(target)) {
      breaches.push_back(Where(include));
    }
  }
  return breaches;
}

/// A folder from which the arrows lead back to itself; "" if there is none.
std::string Circle(const Arrows& arrows) {
  std::map<std::string, std::set<std::string>> reached = arrows;
  for (std::size_t i = 0; i < arrows.size(); ++i) {
    for (auto& [folder, targets] : reached) {
      for (const std::string& target : std::set<std::string>(targets)) {
        const auto further = arrows.find(target);
        if (further != arrows.end()) targets.insert(further->second.begin(), further->second.end());
      }
    }
  }
  for (const auto& [folder, targets] : reached) {
    if (targets.contains(folder)) return folder;
  }
  return "";
}

/// The number of folders on the longest path of `arrows`. Contract: no circle.
std::size_t Floors(const Arrows& arrows) {
  std::map<std::string, std::size_t> floor;
  for (std::size_t round = 0; round < arrows.size(); ++round) {
    for (const auto& [folder, targets] : arrows) {
      std::size_t below = 0;
      for (const std::string& target : targets) below = std::max(below, floor[target]);
      floor[folder] = below + 1;
    }
  }
  std::size_t highest = 0;
  for (const auto& [folder, at] : floor) highest = std::max(highest, at);
  return highest;
}

TEST(Layering, CoreHasSixFloors) {
  EXPECT_EQ(Floors(kCore), 6U);
  EXPECT_EQ(Floors({{"a", {}}, {"b", {"a"}}, {"c", {"a", "b"}}}), 3U);
}

TEST(Layering, OnlyTheFilterIncludesItsLanes) {
  int seen = 0;
  for (const std::string folder : {"core", "hardware", "server"}) {
    for (const Include& include : IncludesUnder(folder)) {
      if (!StartsWith(include.target, "core/filter/simd/")) continue;
      ++seen;
      EXPECT_TRUE(StartsWith(include.file, "core/filter/")) << Where(include);
    }
  }
  EXPECT_GT(seen, 0);
}

TEST(Layering, CoreFoldersPointOnlyDownwards) {
  const std::vector<Include> includes = IncludesUnder("core");
  EXPECT_GT(includes.size(), 50U);
  EXPECT_THAT(Breaches("core", kCore, {}, includes), testing::IsEmpty());
  EXPECT_EQ(Circle(kCore), "");
}

TEST(Layering, ServerFoldersPointOnlyDownwards) {
  const std::vector<Include> includes = IncludesUnder("server");
  EXPECT_GT(includes.size(), 500U);
  EXPECT_THAT(Breaches("server",
                       kServer,
                       {"address_key.h",
                        "clock.h",
                        "disk_ballast.h",
                        "disk_reserve.h",
                        "repeated.h",
                        "spool.h",
                        "wall_time.h"},
                       includes),
              testing::IsEmpty());
  EXPECT_EQ(Circle(kServer), "");
}

TEST(Layering, FindsAnArrowThatPointsUp) {
  const auto breaches = [](const std::string& file, const std::string& target) {
    return Breaches("server", kServer, {"clock.h"}, {{"server/" + file, 1, "server/" + target}});
  };
  EXPECT_THAT(breaches("run/run.cc", "stream/stream_hub.h"), testing::IsEmpty());
  EXPECT_THAT(breaches("stream/viewer.h", "clock.h"), testing::IsEmpty());
  EXPECT_THAT(breaches("storage/database.h", "run/run.h"), testing::SizeIs(1));
  EXPECT_THAT(breaches("lab/scheduler.h", "api/gate.h"), testing::SizeIs(1));
  EXPECT_THAT(breaches("api/sharing/rigs.cc", "api/gate.h"), testing::IsEmpty());
  EXPECT_THAT(breaches("api/lab/rigs.cc", "config.h"), testing::SizeIs(1));
  EXPECT_THAT(breaches("novel/novel.cc", "clock.h"), testing::SizeIs(1)) << "a new folder";
  EXPECT_NE(Circle({{"a", {"b"}}, {"b", {"c"}}, {"c", {"a"}}}), "");
}

/// A library is included only where its wrapper is.
TEST(Layering, LibrariesStayInTheirFolders) {
  const std::map<std::string, std::vector<std::string>> homes = {
      {"CLI/", {"hardware/rig_program/", "server/cli/"}},
      {"boost/asio", {"server/net/"}},
      {"boost/beast", {"server/net/"}},
      {"comedi", {"hardware/comedi/"}},
      {"date/",
       {"server/api/iso8601.cc",
        "server/api/sharing/recurrence.cc",
        "server/mail/letter.cc",
        "server/notify/message.cc"}},
      {"libical/", {"server/api/sharing/recurrence.cc"}},
      {"libpq-fe", {"server/storage/"}},
      {"lcm/", {"hardware/lcm/"}},
      {"opencv2/", {"server/plots/"}},
      {"curl/", {"server/mail/smtp_client.cc", "server/web_client/web_client.cc"}},
      {"openssl/", {"server/net/forwarding_seal.cc", "server/net/websocket.cc", "server/oidc/"}},
      {"soci/",
       {"server/storage/",
        "server/auth/",
        "server/course/",
        "server/fault_sets/",
        "server/idempotency/",
        "server/jobs/",
        "server/lab/",
        "server/notify/",
        "server/privacy/"}},
      {"spdlog/", {"server/app/"}},
      {"toml++/", {"hardware/config/toml_table.cc"}},
  };
  std::set<std::string> seen;
  for (const std::string folder : {"core", "hardware", "server"}) {
    for (const Include& include : IncludesUnder(folder)) {
      for (const auto& [library, places] : homes) {
        if (!StartsWith(include.target, library)) continue;
        seen.insert(library);
        EXPECT_TRUE(std::any_of(places.begin(), places.end(), [&](const std::string& place) {
          return StartsWith(include.file, place);
        })) << Where(include);
      }
    }
  }
  EXPECT_EQ(seen.size(), homes.size()) << "a library that nobody includes has a home here";
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

TEST(Layering, NothingOfTheProductPointsAtItsTests) {
  for (const std::string folder : {"core", "hardware", "server"}) {
    for (const Include& include : IncludesUnder(folder)) {
      EXPECT_FALSE(StartsWith(include.target, "tests/")) << Where(include);
      EXPECT_FALSE(StartsWith(include.target, "gtest/")) << Where(include);
      EXPECT_FALSE(StartsWith(include.target, "../")) << Where(include);
    }
  }
}

/// Calls that core's sources must not contain, from whatever header (Random::Random belongs to
/// core).
TEST(Layering, CoreInvertsNoMatrixDrawsNoUnseededNumberAndPrintsNothing) {
  const std::regex pattern(
      R"(\.inverse\(\)|[^m]::Random\(|std::rand\b|::now\(\)|\bf?(open|printf|puts)\()");
  const auto suspicious = [](const std::string& code) {  // a regex takes long
    return ContainsAny(code,
                       {"inverse(", "::Random(", "rand", "now(", "open(", "printf(", "puts("});
  };
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
      EXPECT_FALSE(suspicious(code) && std::regex_search(code, pattern))
          << fs::relative(entry.path(), kRoot).string() << ":" << line << ": " << text;
    }
  }
  EXPECT_GT(lines, 1000);
}

/// Source without its // comments, by line.
std::vector<std::string> CodeOf(const fs::path& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string text; std::getline(file, text);)
    lines.push_back(text.substr(0, text.find("//")));
  return lines;
}

TEST(Benches, NoConstantOfThePapersStandsOutsideItsDescription) {
  // Its parts and its data sheet. The paper's own tables and figures are of that bench alone, and a
  // structure names its parameters.
  static const std::regex kConstant(
      R"re("(R1|R9|R12|C8)"|\b7\.41\b|\b25\.5e-3\b|\b1\.43e-6\b|\b0\.77e-3\b|\b47e-12\b|\b1\.8e-6\b|\b9\.5e-3\b|\b0\.0095\b)re");
  const std::vector<std::string> kParts = {
      "\"R", "\"C8", "7.41", "25.5e", "1.43e", "0.77e", "47e-", "1.8e-", "9.5e-", "0.0095"};
  const std::vector<std::string> excepted = {
      "core/paper/", "core/structures/inverting_amplifier/", "server/cli/paper_pictures.cc"};
  std::vector<std::string> found;
  for (const char* folder : {"core", "hardware", "server"}) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string name = fs::relative(entry.path(), kRoot).string();
      const std::string extension = entry.path().extension().string();
      if (!entry.is_regular_file() || (extension != ".h" && extension != ".cc")) continue;
      if (std::any_of(excepted.begin(), excepted.end(), [&](const std::string& each) {
            return StartsWith(name, each);
          })) {
        continue;
      }
      int line = 0;
      for (const std::string& code : CodeOf(entry.path())) {
        ++line;
        if (ContainsAny(code, kParts) && std::regex_search(code, kConstant)) {
          found.push_back(name + ":" + std::to_string(line) + ": " + code);
        }
      }
    }
  }
  EXPECT_THAT(found, testing::IsEmpty());
}

}  // namespace
