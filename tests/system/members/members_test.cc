// Servers on one PostgreSQL, as processes: `a` has no bench, `b` has one. Most requests go to `a`.
#include <gtest/gtest.h>
#include <soci/soci.h>

#include <boost/json.hpp>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>
#include <vector>

#include "server/auth/accounts.h"
#include "server/clock.h"
#include "server/lab/lab_id.h"
#include "server/lab/members.h"
#include "server/net/forwarding_seal.h"
#include "tests/support/await.h"
#include "tests/support/camera_site.h"
#include "tests/support/json_schema.h"
#include "tests/support/loopback_listener.h"
#include "tests/support/paths.h"
#include "tests/support/postgres_cluster.h"
#include "tests/support/raw_client.h"
#include "tests/support/temp_folder.h"
#include "tests/system/members/member_process.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;
using tests::MemberProcess;
using tests::RawClient;
using tests::WebSocketClient;

/// Nothing here takes this long, on any machine.

WallTime Now() {
  return SystemClock().Wall();
}

std::string ReadText(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// The servers and their database live as long as the suite, because each start takes a second.
struct Servers {
  tests::TempFolder folder;
  const std::string location = tests::PostgresCluster::Instance().CreateDatabase();
  tests::CameraSite camera;  ///< of b's bench
  MemberProcess a{folder.path(), "a", location, kOneSimulator};
  MemberProcess b{folder.path(),
                  "b",
                  location,
                  std::string(kOneSimulator) +
                      "[lab]\nbenches = 1\n[[camera]]\nrig = \"b-bench-1\"\nsnapshot = \"" +
                      camera.url() + "\"\n"};
  std::unique_ptr<Database> database = Database::Open({.location = location}).value();
  static constexpr const char* kOneSimulator = "[simulators]\ncount = 1\n";
};

class MembersTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { servers_ = std::make_unique<Servers>(); }
  static void TearDownTestSuite() { servers_.reset(); }
  MembersTest()
      : a_(servers_->a),
        b_(servers_->b),
        database_(*servers_->database),
        accounts_(database_, GuestAccess::kNever, PasswordCost::kLeast),
        description_(ReadText(tests::InSource("server/api/openapi.json"))) {}

  /// The headers of a person who has signed in: a cookie and its CSRF token.
  std::string Person(const std::string& login, Role role) {
    const std::string password = "correct horse battery";
    const auto account = accounts_.Create(login, login, role, Now());
    const auto link = accounts_.CreateLink(account.value().id, Now());
    EXPECT_TRUE(accounts_.UseLink(link.value(), password, Now()).ok());
    const auto in = accounts_.SignIn({login, password, "127.0.0.1", ""}, Now()).signed_in.value();
    return "Cookie: faultlab_session=" + in.cookie_secret +
           "\r\nX-CSRF-Token: " + in.principal.csrf_token + "\r\n";
  }
  /// Sends a request to a server and checks the answer against the API's description.
  HttpAnswer Ask(int port,
                 const std::string& headers,
                 const std::string& method,
                 const std::string& pattern,
                 const std::string& id = {},
                 const std::string& body = {}) {
    std::string target = "/api/v1/" + pattern;
    if (!id.empty()) target.replace(target.find("{id}"), 4, id);
    HttpAnswer answer =
        tests::Request(port,
                       method,
                       target,
                       headers + (method == "POST" ? "Content-Type: application/json\r\n" : ""),
                       body);
    const auto wrong = description_.CheckAnswer(
        method, "/api/v1/" + pattern, answer.status, answer.Header("Content-Type"), answer.body);
    EXPECT_FALSE(wrong) << method << " " << target << ": " << *wrong << "\n" << answer.body;
    return answer;
  }
  HttpAnswer AskA(const std::string& headers,
                  const std::string& method,
                  const std::string& pattern,
                  const std::string& id = {},
                  const std::string& body = {}) {
    return Ask(a_.port(), headers, method, pattern, id, body);
  }
  json::object Got(int status, const HttpAnswer& answer) {
    EXPECT_EQ(answer.status, status) << answer.body;
    return answer.status == status ? json::parse(answer.body).as_object() : json::object();
  }
  /// Waits until a server knows a rig of another one.
  void WaitForRig(const std::string& id, const std::string& status) {
    ASSERT_TRUE(tests::Await([&] {
      const HttpAnswer health = AskA("", "GET", "rigs/{id}/health", id);
      return health.status == 200 && json::parse(health.body).at("status") == json::value(status);
    })) << id;
  }
  std::string StartRun(const std::string& who, const std::string& body) {
    const json::object run = Got(201, AskA(who, "POST", "runs", {}, body));
    return run.empty() ? std::string() : std::string(run.at("id").as_string());
  }
  std::string CodeFor(const std::string& who, const std::string& run) {
    const json::object token = Got(201, AskA(who, "POST", "runs/{id}/stream-token", run, "{}"));
    return token.empty() ? std::string() : std::string(token.at("code").as_string());
  }
  std::unique_ptr<WebSocketClient> Watch(const std::string& who, const std::string& run) {
    const std::string target = "/ws?code=" + CodeFor(who, run);
    auto viewer = std::make_unique<WebSocketClient>(a_.port(), target);
    EXPECT_EQ(viewer->status(), 101);
    return viewer;
  }

  static constexpr const char* kBench = "b-bench-1";

  static std::unique_ptr<Servers> servers_;
  MemberProcess& a_;
  MemberProcess& b_;
  Database& database_;
  Accounts accounts_;
  tests::ApiDescription description_;
};

std::unique_ptr<Servers> MembersTest::servers_;

TEST_F(MembersTest, ABenchOfAnotherMemberIsUsedThroughThisOne) {
  const std::string ann = Person("ann", Role::kStudent);
  WaitForRig(kBench, "ready");
  const json::object asked = Got(201, AskA(ann, "POST", "tickets", {}, R"({"rig_class":"bench"})"));
  const std::string ticket = std::to_string(asked.at("ticket").at("id").as_int64());
  const json::object session = Got(200, AskA(ann, "POST", "tickets/{id}/accept", ticket, "{}"));
  // The list from which the page chooses: the rigs of both.
  std::set<std::string> rigs;
  const json::object list = Got(200, AskA(ann, "GET", "rigs"));
  for (const json::value& rig : list.at("items").as_array()) {
    rigs.emplace(rig.at("id").as_string());
  }
  EXPECT_EQ(rigs, (std::set<std::string>{"a-sim-1", "b-bench-1", "b-sim-1"}));

  const std::string run = StartRun(ann, R"({"rig":"b-bench-1","duration_s":600})");
  auto viewer = Watch(ann, run);
  const auto hello = viewer->ReadTextWith("\"hello\"");
  ASSERT_TRUE(hello);
  EXPECT_EQ(json::parse(*hello).at("run"), json::value(run));
  EXPECT_TRUE(json::parse(*hello).at("can_command").as_bool());
  auto frame = viewer->Read();
  while (frame && frame->opcode != 2) frame = viewer->Read();
  ASSERT_TRUE(frame) << "signals come through";

  viewer->SendText(R"({"type":"command","epoch":)" + json::serialize(session.at("epoch")) +
                   R"(,"id":"7","action":"set","component":"R1","value":100})");
  const auto ack = viewer->ReadTextWith("\"ack\"");
  ASSERT_TRUE(ack);
  EXPECT_TRUE(json::parse(*ack).at("ok").as_bool()) << *ack;
  // The live run, its events and its picture; the session refers to its run.
  ASSERT_TRUE(tests::Await([&] {
    const auto events = Got(200, AskA(ann, "GET", "runs/{id}/events", run)).at("items");
    return json::serialize(events).find("fault_commanded") != std::string::npos;
  })) << "an event that is not stored yet";
  const json::object live = Got(200, AskA(ann, "GET", "runs/{id}", run));
  EXPECT_EQ(live.at("state"), "running");
  EXPECT_GT(live.at("samples").to_number<int>(), 0);
  EXPECT_TRUE(live.at("camera").as_bool());
  const HttpAnswer picture = AskA(ann, "GET", "runs/{id}/camera", run);
  EXPECT_EQ(picture.status, 200);
  EXPECT_EQ(picture.Header("Content-Type"), "image/jpeg");
  EXPECT_FALSE(picture.Header("X-Picture-Age-Ms").empty());
  ASSERT_TRUE(tests::Await([&] {
    const auto figure = tests::Get(a_.port(), "/api/v1/runs/" + run + "/figures/signals", ann);
    return figure.status == 200;
  }));
  ASSERT_TRUE(tests::Await([&] {
    const json::object own = Got(200, AskA(ann, "GET", "sessions"));
    const json::object& shown = own.at("items").at(0).as_object();
    return shown.contains("run") && shown.at("run") == json::value(run);
  }));

  Got(202, AskA(ann, "POST", "runs/{id}/stop", run, "{}"));
  EXPECT_TRUE(viewer->ReadTextWith("\"end\"")) << "its viewers are told";
  // A viewer that connects a moment later still gets the end.
  EXPECT_TRUE(Watch(ann, run)->ReadTextWith("\"hello\""));
  ASSERT_TRUE(tests::Await(
      [&] { return Got(200, AskA(ann, "GET", "runs/{id}", run)).at("state") == "stopped"; }));
  EXPECT_EQ(tests::Get(a_.port(), "/api/v1/runs/" + run + "/figures/signals", ann).status, 200);
  EXPECT_EQ(AskA(ann, "POST", "runs/{id}/stop", run, "{}").status, 409);
}

TEST_F(MembersTest, OperatorsAndGuestsReachWhatTheOtherMemberHas) {
  const std::string ann = Person("ben", Role::kStudent);
  const std::string oper = Person("oper", Role::kOperator);
  WaitForRig("b-sim-1", "ready");
  // Only b knows the trip of its bench: none, and the bench has no agent.
  EXPECT_EQ(AskA(oper, "POST", "rigs/{id}/clear-trip", kBench, "{}").status, 409);
  EXPECT_EQ(AskA(oper, "POST", "rigs/{id}/adopt", kBench, "{}").status, 409);
  EXPECT_EQ(AskA(ann, "POST", "rigs/{id}/clear-trip", kBench, "{}").status, 403);
  EXPECT_EQ(AskA(oper, "GET", "rigs/{id}/calibrations", kBench).status, 200);

  // Practice: on the named simulator; a code is accepted by any server.
  const std::string run = StartRun("", R"({"rig":"b-sim-1","duration_s":600})");
  const std::string code = CodeFor("", run);
  {
    WebSocketClient viewer(b_.port(), "/ws?code=" + code);
    EXPECT_TRUE(viewer.ReadTextWith("\"hello\""));
  }
  EXPECT_EQ(WebSocketClient(a_.port(), "/ws?code=" + code).status(), 403) << "once";
  EXPECT_EQ(AskA("", "POST", "runs/{id}/stop", run, "{}").status, 202);
  // A guest from another network is refused by every server.
  const std::string far = "X-Forwarded-For: 203.0.113.9\r\n";
  EXPECT_EQ(AskA(far, "GET", "runs/{id}", run).status, 401);
  // Jobs for the other member's rig are checked with its description, and run there, whichever
  // server claims them.
  const std::string one = R"({"rig":"b-sim-1","duration_s":1})";
  const json::object jobs =
      Got(202, AskA(ann, "POST", "jobs", {}, R"({"runs":[)" + one + "," + one + "," + one + "]}"));
  for (const json::value& job : jobs.at("items").as_array()) {
    const std::string id(job.at("id").as_string());
    json::object now;
    ASSERT_TRUE(tests::Await([&] {
      now = Got(200, AskA(ann, "GET", "jobs/{id}", id));
      return now.at("state") != "waiting" && now.at("state") != "running";
    }));
    EXPECT_EQ(now.at("state"), "finished") << json::serialize(now);
  }
}

TEST_F(MembersTest, AHopIsBelievedFromMembersAloneAndGoesNoFurther) {
  const std::string run = StartRun("", R"({"rig":"a-sim-1","duration_s":600})");
  HttpRequest sent;
  const std::string target = "/api/v1/runs/" + run;
  sent.target = target;
  const auto hop = [&](const std::string& secret, const std::string& client) {
    return "X-Faultlab-Hop: " +
           ForwardingSeal(secret, "a").Seal({client, false}, "b", sent, Now()) + "\r\n";
  };
  const std::string secret = lab::HopSecret(database_).value();
  EXPECT_EQ(tests::Get(b_.port(), target, hop("guessed", "127.0.0.1")).status, 403);
  EXPECT_EQ(Ask(b_.port(), hop(secret, "203.0.113.9"), "GET", "runs/{id}", run).status, 401);
  // a has the run; b reports this instead of asking a.
  const HttpAnswer back = Ask(b_.port(), hop(secret, "127.0.0.1"), "GET", "runs/{id}", run);
  EXPECT_EQ(back.status, 503);
  EXPECT_EQ(back.Header("Retry-After"), "1");
  Got(200, Ask(b_.port(), "", "GET", "runs/{id}", run));
  Got(202, Ask(b_.port(), "", "POST", "runs/{id}/stop", run, "{}"));
}

TEST_F(MembersTest, AMemberThatDiesLeavesItsRunInterrupted) {
  MemberProcess c(servers_->folder.path(), "c", servers_->location, Servers::kOneSimulator);
  WaitForRig("c-sim-1", "ready");
  const std::string run = StartRun("", R"({"rig":"c-sim-1","duration_s":600})");
  auto viewer = Watch("", run);
  ASSERT_TRUE(viewer->ReadTextWith("\"hello\""));
  c.Kill();
  while (viewer->Read()) {
  }
  EXPECT_TRUE(viewer->WaitForClose()) << "the tunnel ends with it";
  const HttpAnswer lost = AskA("", "POST", "runs/{id}/stop", run, "{}");
  EXPECT_EQ(lost.status, 503);
  EXPECT_NE(lost.body.find("Server 'c' has what this is about and cannot be reached"),
            std::string::npos)
      << lost.body;
  EXPECT_EQ(AskA("", "GET", "rigs").status, 200) << "a's own rigs";
  // Its lease ends, and the others end its runs.
  ASSERT_TRUE(database_
                  .Write(Durability::kPromise,
                         [](Transaction& tx) -> core::Status {
                           tx.sql() << "UPDATE lab_member SET lease_until_ms = 0 WHERE id = 'c'";
                           return core::Done{};
                         })
                  .ok());
  std::string state;
  ASSERT_TRUE(tests::Await([&] {
    const HttpAnswer answer = AskA("", "GET", "runs/{id}", run);
    EXPECT_TRUE(answer.status == 503 || answer.status == 200) << answer.body;
    if (answer.status == 200) state = json::parse(answer.body).at("state").as_string();
    return state == "interrupted";
  })) << state;
  EXPECT_EQ(AskA("", "POST", "runs/{id}/stop", run, "{}").status, 409);
}

TEST_F(MembersTest, AFrozenMembersJobIsDoneAgainAndItsOwnEndOfItIsRefused) {
  const std::string ann = Person("again", Role::kStudent);
  MemberProcess c(servers_->folder.path(), "c", servers_->location, Servers::kOneSimulator);
  WaitForRig("c-sim-1", "ready");
  const json::object batch =
      Got(202, Ask(c.port(), ann, "POST", "jobs", {}, R"({"runs":[{"duration_s":6}]})"));
  const std::string id(batch.at("items").at(0).at("id").as_string());
  json::object job;
  const auto is = [&](int attempts, const char* state) {
    job = Got(200, AskA(ann, "GET", "jobs/{id}", id));
    return job.at("attempts") == attempts && job.at("state") == state && job.at("run").is_string();
  };
  // Nothing tells the other members of the job; c looks for it at once.
  ASSERT_TRUE(tests::Await([&] { return is(1, "running"); }));
  const std::string first(job.at("run").as_string());
  c.Freeze();
  ASSERT_TRUE(database_
                  .Write(Durability::kPromise,
                         [](Transaction& tx) -> core::Status {
                           tx.sql() << "UPDATE lab_member SET lease_until_ms = 0 WHERE id = 'c'";
                           return core::Done{};
                         })
                  .ok());
  ASSERT_TRUE(tests::Await([&] { return is(2, "running"); })) << json::serialize(job);
  const std::string second(job.at("run").as_string());
  c.Wake();
  WaitForRig("c-sim-1", "ready");  // it has joined again
  ASSERT_TRUE(tests::Await([&] { return is(2, "finished"); })) << json::serialize(job);
  EXPECT_EQ(job.at("run"), json::string(second));
  EXPECT_NE(first, second);
  EXPECT_EQ(Got(200, AskA(ann, "GET", "runs/{id}", first)).at("state"), "interrupted");
  EXPECT_EQ(Got(200, AskA(ann, "GET", "runs/{id}", second)).at("samples"), 600);
}

TEST_F(MembersTest, JobsAreCancelledAtAnyMember) {
  const std::string ann = Person("cancels", Role::kStudent);
  std::string runs;
  for (int i = 0; i < 60; ++i) {
    runs += std::string(i > 0 ? "," : "") + R"({"rig":"b-sim-1","duration_s":600})";
  }
  const json::object made = Got(202, AskA(ann, "POST", "jobs", {}, R"({"runs":[)" + runs + "]}"));
  const std::string first(made.at("items").at(0).at("id").as_string());
  const std::string batch(made.at("batch").as_string());
  ASSERT_TRUE(tests::Await(
      [&] { return Got(200, AskA(ann, "GET", "jobs/{id}", first)).at("run").is_string(); }));
  EXPECT_EQ(AskA(ann, "DELETE", "jobs/batches/{id}", batch).status, 204);
  const json::object left = Got(200, AskA(ann, "GET", "jobs/batches/{id}", batch));
  EXPECT_EQ(left.at("waiting"), 0);
  EXPECT_EQ(left.at("running"), 0);
  EXPECT_GT(left.at("cancelled").as_int64(), 30);
  // What b played of them is stopped there, or over.
  const std::string run(Got(200, AskA(ann, "GET", "jobs/{id}", first)).at("run").as_string());
  EXPECT_TRUE(tests::Await(
      [&] { return Got(200, AskA(ann, "GET", "runs/{id}", run)).at("state") != "running"; }));
}

TEST_F(MembersTest, WhoAsksASilentMemberOftenLeavesRoomForOthersOfTheSameAddress) {
  const std::string ann = Person("often", Role::kStudent);
  const std::string mila = Person("once", Role::kStudent);
  const tests::LoopbackListener silent;
  const auto until = [&](std::chrono::hours from_now) {
    const lab::Member member{"silent", "boot", silent.address(), Now() + from_now};
    return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
      lab::members::Put(tx, member);
      return core::Done{};
    });
  };
  ASSERT_TRUE(until(std::chrono::hours(1)).ok());
  ASSERT_TRUE(tests::Await([&] {
    EXPECT_EQ(AskA(mila, "GET", "rigs").status, 200);
    return silent.HasBeenAsked();
  }));
  // A list waits 3 s for the silent server; far more lists come at once than one caller may have.
  std::vector<std::unique_ptr<RawClient>> lists;
  for (int i = 0; i < 80; ++i) {
    lists.push_back(std::make_unique<RawClient>(a_.port()));
    lists.back()->Send("GET /api/v1/rigs HTTP/1.1\r\nHost: localhost\r\n" + ann + "\r\n");
  }
  EXPECT_EQ(AskA(mila, "GET", "rigs").status, 200);
  int answered = 0;
  int refused = 0;
  for (const auto& list : lists) {
    const HttpAnswer answer = list->ReadAnswer();
    answered += answer.status == 200 ? 1 : 0;
    refused += answer.status == 429 && answer.Header("Retry-After") == "1" ? 1 : 0;
  }
  EXPECT_GT(answered, 0);
  EXPECT_GT(refused, 0);
  EXPECT_EQ(answered + refused, 80);
  EXPECT_TRUE(until(-std::chrono::hours(1)).ok());
}

}  // namespace
}  // namespace faultlab::server
