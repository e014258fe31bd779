// The real program is killed with SIGKILL right after, and during, each transition of the lab;
// everything that it had answered must be there when it starts again.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <thread>

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
  /// Sends a request and kills the server without waiting for the answer.
  void KillInTheMiddleOf(const std::string& who,
                         const std::string& target,
                         const std::string& body) {
    tests::RawClient client(server_->port());
    client.Send("POST /api/v1/" + target + " HTTP/1.1\r\nHost: 127.0.0.1\r\n" + keys_[who] +
                "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
    // Different moments: before, in and after the transaction.
    std::this_thread::sleep_for(std::chrono::microseconds(300 * (kills_++ % 12)));
    server_->Kill();
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
  json::object Started(const std::string& who) { return Accepted(who, AskedTicket(who)); }
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
  int kills_ = 0;
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

  // Ended: nobody has the rig, and it is checked before Bob gets it.
  const std::string id = std::to_string(session.at("id").as_int64());
  EXPECT_EQ(Call("ann", "POST", "sessions/" + id + "/end", "{}").status, 204);
  Restart();
  EXPECT_TRUE(Items("ann", "sessions").empty());
  EXPECT_TRUE(tests::Await([&] { return Items("bob", "tickets")[0].at("state") == "offered"; }));

  // Booked and cancelled.
  const std::string start = "2099-01-01T00:00:00Z";
  EXPECT_EQ(Call("ann",
                 "POST",
                 "bookings",
                 R"({"rig_class":"bench","start":")" + start + R"(","end":"2099-01-01T01:00:00Z"})")
                .status,
            400)
      << "too far ahead";
  const auto in = [](int minutes) {
    const std::time_t time = std::time(nullptr) + minutes * 60;
    char text[32];
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", std::gmtime(&time));
    return std::string(text);
  };
  const json::object booking =
      Ok(Call("ann",
              "POST",
              "bookings",
              R"({"rig_class":"bench","start":")" + in(120) + R"(","end":")" + in(150) + "\"}"));
  Restart();
  ASSERT_EQ(Items("ann", "bookings").size(), 1u);
  EXPECT_EQ(Items("ann", "bookings")[0].at("id"), booking.at("id"));
  const std::string version = std::to_string(Items("ann", "bookings")[0].at("version").as_int64());
  EXPECT_EQ(Call("ann",
                 "DELETE",
                 "bookings/" + std::to_string(booking.at("id").as_int64()),
                 {},
                 "If-Match: \"" + version + "\"\r\n")
                .status,
            204);
  Restart();
  EXPECT_TRUE(Items("ann", "bookings").empty());
}

TEST_F(CrashTest, AKillInTheMiddleOfATransitionLeavesAllOrNothingOfIt) {
  for (int round = 0; round < 6; ++round) {
    KillInTheMiddleOf("ann", "tickets", R"({"rig_class":"bench"})");
    Restart();
    EXPECT_LE(Items("ann", "tickets").size(), 1u);
    const json::object session = Started("ann");
    const std::string id = std::to_string(session.at("id").as_int64());
    KillInTheMiddleOf("ann", "sessions/" + id + "/end", "{}");
    Restart();
    const json::array left = Items("ann", "sessions");
    if (!left.empty()) {
      EXPECT_EQ(left[0].at("epoch"), session.at("epoch"));
      EXPECT_EQ(Call("ann", "POST", "sessions/" + id + "/end", "{}").status, 204);
    }
    WaitForBench();
  }
}

}  // namespace
}  // namespace faultlab::server
