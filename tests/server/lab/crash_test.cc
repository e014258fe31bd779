// The real program is killed with SIGKILL, also in mid-run; everything that it had answered must be
// there when it starts again. Kills at every commit: crash_everywhere_test.cc.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>

#include "server/auth/accounts.h"
#include "server/lab/lab_store.h"
#include "server/storage/recording_store.h"
#include "tests/support/await.h"
#include "tests/support/paths.h"
#include "tests/support/raw_client.h"
#include "tests/support/temp_folder.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;

WallTime Now() {
  return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
}

/// `faultlab serve` as its own process.
class Server {
 public:
  explicit Server(const tests::TempFolder& folder) : log_(folder.File("log")) {
    const std::string config = folder.File("config.toml");
    std::ofstream(config) << "listen = \"127.0.0.1:0\"\ndata_dir = \"" << folder.File("data")
                          << "\"\n[simulators]\nspeed = 20.0\ncount = 1\n[lab]\nbenches = 1\n";
    std::ofstream(log_, std::ios::trunc).flush();
    const pid_t parent = getpid();
    const std::string program = tests::Program();
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(126);
      const int out = open(log_.c_str(), O_WRONLY | O_APPEND);
      dup2(out, STDOUT_FILENO);
      dup2(out, STDERR_FILENO);
      execl(program.c_str(), program.c_str(), "serve", "--config", config.c_str(), nullptr);
      _exit(127);
    }
    const std::string listening = "listening on http://127.0.0.1:";
    EXPECT_TRUE(tests::Await([&] {
      std::ifstream in(log_);
      std::ostringstream text;
      text << in.rdbuf();
      const std::size_t at = text.str().find(listening);
      if (at != std::string::npos) port_ = std::stoi(text.str().substr(at + listening.size()));
      return port_ != 0;
    })) << "the server did not start; see "
        << log_;
  }
  ~Server() { Kill(); }
  void Kill() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  int port() const { return port_; }

 private:
  std::string log_;
  pid_t pid_ = -1;
  int port_ = 0;
};

class CrashTest : public ::testing::Test {
 protected:
  CrashTest() {
    std::filesystem::create_directories(folder_.File("data"));
    auto database = Database::Open({.location = folder_.File("data/faultlab.db")}).value();
    Accounts accounts(*database, GuestAccess::kNever);
    for (const char* login : {"ann", "bob"}) {
      Principal who;
      who.user_id = accounts.Create(login, login, Role::kStudent, Now()).value().id;
      const auto key = accounts.CreateKey(
          who, "k", {"lab", "runs:read", "runs:write"}, Now() + std::chrono::hours(1), Now());
      keys_[login] =
          "Authorization: Bearer " + key.value().secret + "\r\nContent-Type: application/json\r\n";
    }
    server_ = std::make_unique<Server>(folder_);
    WaitForBench();
  }

  HttpAnswer Call(const std::string& who,
                  const std::string& method,
                  const std::string& target,
                  const std::string& body = {},
                  const std::string& more = {}) {
    return tests::Request(server_->port(), method, "/api/v1/" + target, keys_[who] + more, body);
  }
  json::object Ok(const HttpAnswer& answer) {
    EXPECT_TRUE(answer.status >= 200 && answer.status < 300) << answer.status << answer.body;
    return answer.body.empty() ? json::object{} : json::parse(answer.body).as_object();
  }
  std::string BenchStatus() {
    const json::object health = Ok(Call("ann", "GET", "rigs/bench-1/health"));
    return std::string(health.at("status").as_string());
  }
  void WaitForBench() {
    EXPECT_TRUE(tests::Await([&] { return BenchStatus() == "ready"; })) << BenchStatus();
  }
  void Restart() {
    server_->Kill();
    CheckTheDisk();
    server_ = std::make_unique<Server>(folder_);
  }
  /// After a kill: the stored state satisfies every invariant of the scheduler.
  void CheckTheDisk() {
    auto database = Database::Open({.location = folder_.File("data/faultlab.db")});
    ASSERT_TRUE(database.ok()) << database.error().message;
    EXPECT_TRUE(database.value()->Check().ok());
    lab::LabState state;
    ASSERT_TRUE(database.value()
                    ->Read([&](Transaction& tx) -> core::Status {
                      state = lab::lab_store::Load(tx);
                      return core::Done{};
                    })
                    .ok());
    EXPECT_EQ(lab::FindBrokenInvariant(state), "");
  }
  std::int64_t AskedTicket(const std::string& who) {
    const json::object answer = Ok(Call(who, "POST", "tickets", R"({"rig_class":"bench"})"));
    return answer.at("ticket").at("id").as_int64();
  }
  /// Accepts the ticket as soon as the rig is offered.
  json::object Accepted(const std::string& who, std::int64_t ticket) {
    const std::string accept = "tickets/" + std::to_string(ticket) + "/accept";
    HttpAnswer answer = Call(who, "POST", accept, "{}");
    EXPECT_TRUE(tests::Await([&] {
      if (answer.status == 409) answer = Call(who, "POST", accept, "{}");
      return answer.status != 409;
    }));
    return Ok(answer);
  }
  json::array Items(const std::string& who, const std::string& list) {
    return Ok(Call(who, "GET", list)).at("items").as_array();
  }

  tests::TempFolder folder_;
  std::map<std::string, std::string> keys_;
  std::unique_ptr<Server> server_;
};

TEST_F(CrashTest, WhateverWasAnsweredIsThereAfterTheKill) {
  // Requested: both tickets are there in their order; the rig is checked again before anybody gets
  // it.
  const std::int64_t ann_ticket = AskedTicket("ann");
  const std::int64_t bob_ticket = AskedTicket("bob");
  Restart();
  ASSERT_EQ(Items("ann", "tickets").size(), 1u);
  EXPECT_EQ(Items("ann", "tickets")[0].at("id"), ann_ticket);
  EXPECT_EQ(Items("bob", "tickets")[0].at("id"), bob_ticket);

  // Accepted: the session with its epoch.
  const json::object session = Accepted("ann", ann_ticket);
  Restart();
  const json::array sessions = Items("ann", "sessions");
  ASSERT_EQ(sessions.size(), 1u);
  EXPECT_EQ(sessions[0].at("id"), session.at("id"));
  EXPECT_EQ(sessions[0].at("epoch"), session.at("epoch"));

  // During a run: it is marked as interrupted, and its recorded samples are there.
  const json::object run = Ok(Call("ann", "POST", "runs", R"({"rig":"bench-1","duration_s":600})"));
  const std::string run_path = "runs/" + std::string(run.at("id").as_string());
  EXPECT_TRUE(tests::Await(
      [&] { return Ok(Call("ann", "GET", run_path)).at("samples").as_int64() >= 500; }));
  const std::int64_t seen = Ok(Call("ann", "GET", run_path)).at("samples").as_int64();
  server_->Kill();
  const json::object cut = [&] {
    Restart();
    return Ok(Call("ann", "GET", run_path));
  }();
  EXPECT_EQ(cut.at("state"), "interrupted");
  // One second of wall time at 20 times the pace is 2000 samples.
  EXPECT_GE(cut.at("samples").as_int64(), seen - 2000);
  EXPECT_GT(cut.at("samples").as_int64(), 0);
}

}  // namespace
}  // namespace faultlab::server
