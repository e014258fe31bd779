// The lab over HTTP, in a whole server in this process; every answer is held against the API's
// description.
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>
#include <thread>

#include "server/api/lab_api.h"
#include "server/app/laboratory.h"
#include "server/auth/accounts.h"
#include "tests/support/json_schema.h"
#include "tests/support/raw_client.h"
#include "tests/support/temp_folder.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;

const std::string kPassword = "correct horse battery";
constexpr const char* kApi = "/api/v1/";

std::string ReadText(const std::string& path) {
  std::ifstream in(path);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// How somebody proves who they are.
struct Person {
  std::string headers;
};

class LabApiTest : public ::testing::Test {
 protected:
  LabApiTest() : description_(ReadText(FAULTLAB_SOURCE_DIR "/server/api/openapi.json")) {
    config_.listen = "127.0.0.1:0";
    config_.data_dir = folder_.File("data");
    config_.sim_speed = 50.0;
    config_.lab_benches = 2;
    auto opened = Laboratory::Open(config_);
    EXPECT_TRUE(opened.ok()) << opened.error().message;
    laboratory_ = std::move(opened).value();
    database_ = Database::Open({.location = config_.data_dir + "/faultlab.db"}).value();
    accounts_ = std::make_unique<Accounts>(*database_, GuestAccess::kNever);
  }

  static WallTime Now() {
    return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now());
  }
  /// Pattern and target below /api/v1/; checks the answer against the description.
  HttpAnswer Call(const Person& who,
                  const std::string& method,
                  const std::string& pattern,
                  const std::string& target,
                  const std::string& body = {},
                  const std::string& more_headers = {}) {
    std::string headers = who.headers + more_headers;
    if (!body.empty() && headers.find("Content-Type") == std::string::npos) {
      headers += "Content-Type: application/json\r\n";
    }
    HttpAnswer answer = tests::Request(laboratory_->port(), method, kApi + target, headers, body);
    const auto error = description_.CheckAnswer(
        method, kApi + pattern, answer.status, answer.Header("Content-Type"), answer.body);
    EXPECT_FALSE(error) << method << " " << target << ": " << *error << "\n" << answer.body;
    return answer;
  }
  json::object Ok(const HttpAnswer& answer, int status = 200) {
    EXPECT_EQ(answer.status, status) << answer.body;
    if (answer.status != status || answer.body.empty()) return {};
    return json::parse(answer.body).as_object();
  }

  Person ByPassword(const std::string& login) {
    const HttpAnswer answer =
        Call({},
             "POST",
             "auth/login",
             "auth/login",
             json::serialize(json::object{{"login", login}, {"password", kPassword}}));
    const json::object me = Ok(answer);
    const std::string cookie = answer.Header("Set-Cookie");
    EXPECT_NE(cookie.find("HttpOnly; SameSite=Lax"), std::string::npos) << cookie;
    return {"Cookie: " + cookie.substr(0, cookie.find(';')) +
            "\r\nX-CSRF-Token: " + std::string(me.at("csrf_token").as_string()) + "\r\n"};
  }
  Person Admin() {
    const auto link = accounts_->FirstStartLink(Now()).value();
    EXPECT_TRUE(link.has_value());
    const HttpAnswer set =
        Call({},
             "POST",
             "auth/reset",
             "auth/reset",
             json::serialize(json::object{{"token", *link}, {"password", kPassword}}));
    EXPECT_EQ(set.status, 204) << set.body;
    return ByPassword("admin");
  }
  /// An account with a cookie made below HTTP, for tests that are not about signing in.
  Person Make(const std::string& login, Role role) {
    const auto account = accounts_->Create(login, login, role, Now());
    EXPECT_TRUE(account.ok());
    const auto link = accounts_->CreateLink(account.value().id, Now());
    EXPECT_TRUE(accounts_->UseLink(link.value(), kPassword, Now()).ok());
    const auto in = accounts_->SignIn(login, kPassword, "127.0.0.1", Now());
    EXPECT_TRUE(in.ok());
    return {"Cookie: faultlab_session=" + in.value().cookie_secret +
            "\r\nX-CSRF-Token: " + in.value().principal.csrf_token + "\r\n"};
  }
  void WaitForBenches(int ready) {
    for (int i = 0; i < 1000; ++i) {
      const json::object classes = Ok(Call({}, "GET", "rig-classes", "rig-classes"));
      const json::array& items = classes.at("items").as_array();
      if (!items.empty() && items[0].at("ready").as_int64() >= ready) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    FAIL() << "the benches never passed their check";
  }
  std::string In(std::chrono::minutes from_now) { return Iso8601(Now() + from_now); }

  tests::TempFolder folder_;
  tests::ApiDescription description_;
  Config config_;
  std::unique_ptr<Laboratory> laboratory_;
  std::unique_ptr<Database> database_;
  std::unique_ptr<Accounts> accounts_;
};

std::string Lower(HttpMethod method) {
  std::string name(Name(method));
  std::transform(name.begin(), name.end(), name.begin(), [](char c) {
    return static_cast<char>(std::tolower(c));
  });
  return name;
}

TEST_F(LabApiTest, EveryRouteIsDescribedAndEveryDescribedOperationHasARoute) {
  std::set<std::string> routes;
  for (const auto& table : {ExperimentRoutes(), LabRoutes()}) {
    for (const ApiRoute& route : table) {
      routes.insert(Lower(route.method) + " " + std::string(route.pattern));
    }
  }
  std::set<std::string> described;
  std::set<std::string> ids;
  for (const auto& path : description_.document().at("paths").as_object()) {
    for (const auto& operation : path.value().as_object()) {
      described.insert(std::string(operation.key()) + " " + std::string(path.key()));
      EXPECT_TRUE(ids.insert(std::string(operation.value().at("operationId").as_string())).second);
    }
  }
  EXPECT_EQ(routes, described);
}

TEST_F(LabApiTest, AnAdminMakesPeopleCoursesAndKeysAndTheLogKeepsIt) {
  const Person admin = Admin();
  const json::object ann =
      Ok(Call(admin, "POST", "users", "users", R"({"login":"ann","name":"Ann Ångström 名"})"), 201);
  const std::string ann_id = std::to_string(ann.at("id").as_int64());
  const json::object link = Ok(
      Call(admin, "POST", "users/{id}/reset-link", "users/" + ann_id + "/reset-link", "{}"), 201);
  const std::string path(link.at("link").as_string());
  const std::string token = path.substr(path.find('=') + 1);
  EXPECT_EQ(Call({},
                 "POST",
                 "auth/reset",
                 "auth/reset",
                 json::serialize(json::object{{"token", token}, {"password", kPassword}}))
                .status,
            204);
  const Person student = ByPassword("ann");
  EXPECT_EQ(Call(student, "GET", "users", "users").status, 403);
  EXPECT_EQ(Call({}, "GET", "users", "users").status, 401);

  const HttpAnswer stale = Call(admin,
                                "PATCH",
                                "users/{id}",
                                "users/" + ann_id,
                                R"({"role":"instructor"})",
                                "If-Match: \"7\"\r\n");
  EXPECT_EQ(stale.status, 409);
  EXPECT_EQ(
      Call(admin, "PATCH", "users/{id}", "users/" + ann_id, R"({"role":"instructor"})").status,
      400);
  Ok(Call(admin,
          "PATCH",
          "users/{id}",
          "users/" + ann_id,
          R"({"role":"instructor"})",
          "If-Match: \"1\"\r\n"));
  const json::object course =
      Ok(Call(student, "POST", "courses", "courses", R"({"name":"Regelungstechnik Ω"})"), 201);
  const std::string members = "courses/" + std::to_string(course.at("id").as_int64()) + "/members";
  const json::object enrolled = Ok(Call(student,
                                        "POST",
                                        "courses/{id}/members",
                                        members,
                                        "login,name\nbob,Bob\ncem,Cem\n",
                                        "Content-Type: text/csv\r\n"));
  EXPECT_EQ(enrolled.at("enrolled"), 2);
  EXPECT_EQ(Ok(Call(student, "GET", "courses/{id}/members", members)).at("items").as_array().size(),
            3u);

  const json::object key =
      Ok(Call(student,
              "POST",
              "api-keys",
              "api-keys",
              json::serialize(json::object{{"name", "robot"},
                                           {"scopes", json::array{"runs:read"}},
                                           {"expires_at", In(std::chrono::hours(24))}})),
         201);
  const Person robot{"Authorization: Bearer " + std::string(key.at("key").as_string()) + "\r\n"};
  EXPECT_EQ(Ok(Call(robot, "GET", "auth/me", "auth/me")).at("role"), "service");
  EXPECT_EQ(Call(robot, "GET", "tickets", "tickets").status, 403) << "no scope lab";
  const std::string key_path = "api-keys/" + std::to_string(key.at("id").as_int64());
  EXPECT_EQ(Call(student, "DELETE", "api-keys/{id}", key_path).status, 204);
  EXPECT_EQ(Call(robot, "GET", "auth/me", "auth/me").status, 401);

  std::set<std::string> verbs;
  const json::object log = Ok(Call(admin, "GET", "audit", "audit?limit=100"));
  for (const auto& entry : log.at("items").as_array()) {
    verbs.insert(std::string(entry.at("verb").as_string()));
  }
  for (const char* verb : {"create_user", "reset_link", "change_user", "create_course", "enrol"}) {
    EXPECT_TRUE(verbs.contains(verb)) << verb;
  }
  EXPECT_EQ(Call(admin, "POST", "auth/logout", "auth/logout", "{}").status, 204);
  EXPECT_EQ(Call(admin, "GET", "users", "users").status, 401);
}

TEST_F(LabApiTest, AChangeByCookieWithoutTheTokenOfThePageIsRefused) {
  Person ann = Make("ann", Role::kStudent);
  ann.headers = ann.headers.substr(0, ann.headers.find("X-CSRF"));
  EXPECT_EQ(Call(ann, "GET", "tickets", "tickets").status, 200);
  EXPECT_EQ(Call(ann, "POST", "tickets", "tickets", R"({"rig_class":"bench"})").status, 403);
}

TEST_F(LabApiTest, AStudentQueuesWorksHandsOverAndEnds) {
  const Person ann = Make("ann", Role::kStudent);
  const Person bob = Make("bob", Role::kStudent);
  const Person cem = Make("cem", Role::kStudent);
  WaitForBenches(2);
  EXPECT_EQ(Call(ann, "POST", "runs", "runs", R"({"rig":"bench-1"})").status, 403);

  const std::string ask = R"({"rig_class":"bench","min_s":600,"want_s":1800})";
  const json::object ticket = Ok(Call(ann, "POST", "tickets", "tickets", ask), 201);
  const json::object mine = ticket.at("ticket").as_object();
  EXPECT_EQ(mine.at("state"), "offered");
  const std::string accept = "tickets/" + std::to_string(mine.at("id").as_int64()) + "/accept";
  EXPECT_EQ(Call(bob, "POST", "tickets/{id}/accept", accept, "{}").status, 404);
  const json::object session = Ok(Call(ann, "POST", "tickets/{id}/accept", accept, "{}"));
  const std::string rig(session.at("rig").as_string());
  const std::string id = std::to_string(session.at("id").as_int64());
  EXPECT_EQ(Ok(Call(ann, "POST", "tickets", "tickets", ask), 201).count("session"), 1u)
      << "one's own session comes back";
  const auto foreign = tests::Request(laboratory_->port(),
                                      "POST",
                                      "/api/v1/sessions/" + id + "/end",
                                      bob.headers + "Content-Type: application/json\r\n",
                                      "{}");
  EXPECT_EQ(foreign.status, 404) << "as if it were not there";

  const std::string run_body =
      R"({"rig":")" + rig +
      R"(","duration_s":600,"faults":[{"component":"R1","value":100,"at_s":10}]})";
  EXPECT_EQ(Call(bob, "POST", "runs", "runs", run_body).status, 403);
  const json::object run = Ok(Call(ann, "POST", "runs", "runs", run_body), 201);
  EXPECT_EQ(run.at("rig").as_string(), rig);

  Ok(Call(ann, "POST", "sessions/{id}/still-there", "sessions/" + id + "/still-there", "{}"));
  Ok(Call(ann, "POST", "sessions/{id}/extend", "sessions/" + id + "/extend", "{}"));
  EXPECT_EQ(Call(ann,
                 "POST",
                 "sessions/{id}/handover",
                 "sessions/" + id + "/handover",
                 R"({"to":"nobody-here"})")
                .status,
            400);
  Ok(Call(
      ann, "POST", "sessions/{id}/handover", "sessions/" + id + "/handover", R"({"to":"bob"})"));
  const std::string take = "sessions/" + id + "/handover/accept";
  EXPECT_EQ(Call(cem, "POST", "sessions/{id}/handover/accept", take, "{}").status, 404);
  EXPECT_EQ(Ok(Call(bob, "GET", "sessions", "sessions")).at("items").as_array().size(), 1u);
  const json::object taken = Ok(Call(bob, "POST", "sessions/{id}/handover/accept", take, "{}"));
  EXPECT_GT(taken.at("epoch").as_int64(), session.at("epoch").as_int64());
  EXPECT_EQ(taken.at("user"), "bob");
  laboratory_->runs().Wait(run.at("id").as_string());
  EXPECT_EQ(laboratory_->store().Get(std::string(run.at("id").as_string())).value().state,
            RunState::kStopped)
      << "the old controller's run ends with the control";

  EXPECT_EQ(Call(bob, "POST", "sessions/{id}/end", "sessions/" + id + "/end", "{}").status, 204);
  EXPECT_EQ(Call(bob, "POST", "sessions/{id}/end", "sessions/" + id + "/end", "{}").status, 404);
  WaitForBenches(2);
  const json::object told = Ok(Call(ann, "GET", "events", "events?since=0"));
  EXPECT_FALSE(told.at("items").as_array().empty());
  const std::string next = std::to_string(told.at("next").as_int64());
  EXPECT_TRUE(
      Ok(Call(ann, "GET", "events", "events?since=" + next)).at("items").as_array().empty());
}

TEST_F(LabApiTest, ABookingIsMadeShownInTheCalendarAndCancelledByVersion) {
  const Person ann = Make("ann", Role::kStudent);
  const Person bob = Make("bob", Role::kStudent);
  WaitForBenches(2);
  const auto body = [&](std::chrono::minutes from, std::chrono::minutes to) {
    return json::serialize(
        json::object{{"rig_class", "bench"}, {"start", In(from)}, {"end", In(to)}});
  };
  using std::chrono::minutes;
  const HttpAnswer made = Call(ann, "POST", "bookings", "bookings", body(minutes(60), minutes(90)));
  const json::object booking = Ok(made, 201);
  EXPECT_EQ(made.Header("ETag"), "\"1\"");
  const HttpAnswer calendar = Call(ann, "GET", "calendar.ics", "calendar.ics");
  EXPECT_NE(calendar.body.find("BEGIN:VEVENT\r\nUID:booking-"), std::string::npos);
  EXPECT_EQ(Call(bob, "GET", "calendar.ics", "calendar.ics").body.find("VEVENT"),
            std::string::npos);
  const json::object free =
      Ok(Call(bob, "GET", "rig-classes/{class}/availability", "rig-classes/bench/availability"));
  EXPECT_FALSE(free.at("next_free").as_array().empty());
  EXPECT_EQ(free.at("busy").as_array().size(), 1u);

  const std::string path = "bookings/" + std::to_string(booking.at("id").as_int64());
  EXPECT_EQ(Call(ann, "POST", "bookings/{id}/claim", path + "/claim", "{}").status, 503);
  EXPECT_EQ(Call(ann, "DELETE", "bookings/{id}", path).status, 400);
  EXPECT_EQ(Call(bob, "DELETE", "bookings/{id}", path, {}, "If-Match: \"1\"\r\n").status, 404);
  EXPECT_EQ(Call(ann, "DELETE", "bookings/{id}", path, {}, "If-Match: \"2\"\r\n").status, 409);
  EXPECT_EQ(Call(ann, "DELETE", "bookings/{id}", path, {}, "If-Match: \"1\"\r\n").status, 204);

  const auto field = [&](const std::string& start, const std::string& end) {
    const json::object wanted{{"rig_class", "bench"}, {"start", start}, {"end", end}};
    const HttpAnswer answer = Call(ann, "POST", "bookings", "bookings", json::serialize(wanted));
    EXPECT_EQ(answer.status, 400) << answer.body;
    return std::string(json::parse(answer.body).at("field").as_string());
  };
  EXPECT_EQ(field(In(minutes(-60)), In(minutes(30))), "/start");
  EXPECT_EQ(field(In(minutes(60)), In(minutes(60) + std::chrono::hours(24 * 3650))), "/end");
  EXPECT_EQ(field("2027-03-28 02:30 Europe/Berlin", In(minutes(30))), "/start");
  EXPECT_EQ(field("2027-03-28T02:30:00", In(minutes(30))), "/start");
}

TEST_F(LabApiTest, EveryStartThatIsOfferedLiesAheadAndCanBeBooked) {
  const Person ann = Make("ann", Role::kStudent);
  WaitForBenches(2);
  const WallTime asked = Now();
  const json::object answer =
      Ok(Call(ann, "GET", "rig-classes/{class}/availability", "rig-classes/bench/availability"));
  const json::array& offered = answer.at("next_free").as_array();
  ASSERT_FALSE(offered.empty());
  for (const json::value& each : offered) {
    const WallTime start = ParseIso8601(each.at("start").as_string(), "start").value();
    EXPECT_GE(start - asked, std::chrono::minutes(1)) << each;
    EXPECT_EQ(start.time_since_epoch() % std::chrono::minutes(5), std::chrono::minutes(0)) << each;
  }
  const json::object wish{
      {"rig_class", "bench"}, {"start", offered[0].at("start")}, {"end", offered[0].at("end")}};
  Ok(Call(ann, "POST", "bookings", "bookings", json::serialize(wish)), 201);
}

TEST_F(LabApiTest, TheSameKeyIsDoneOnceAndAnotherRequestWithItIsRefused) {
  const Person ann = Make("ann", Role::kStudent);
  WaitForBenches(2);
  const std::string key = "Idempotency-Key: abc\r\n";
  const json::object wanted{{"rig_class", "bench"},
                            {"start", In(std::chrono::minutes(60))},
                            {"end", In(std::chrono::minutes(90))}};
  const std::string body = json::serialize(wanted);
  const HttpAnswer first = Call(ann, "POST", "bookings", "bookings", body, key);
  const HttpAnswer second = Call(ann, "POST", "bookings", "bookings", body, key);
  EXPECT_EQ(first.status, 201);
  EXPECT_EQ(second.status, 201);
  EXPECT_EQ(first.body, second.body);
  EXPECT_EQ(second.Header("Idempotency-Replayed"), "true");
  EXPECT_EQ(Ok(Call(ann, "GET", "bookings", "bookings")).at("items").as_array().size(), 1u);
  EXPECT_EQ(Call(ann, "POST", "tickets", "tickets", R"({"rig_class":"bench"})", key).status, 409);
}

TEST_F(LabApiTest, AnOperatorTakesRigsOutAndBringsThemBackThroughACheck) {
  const Person op = Make("operator1", Role::kOperator);
  const Person ann = Make("ann", Role::kStudent);
  WaitForBenches(2);
  const std::string quarantine = "rigs/bench-1/quarantine";
  EXPECT_EQ(Call(ann, "POST", "rigs/{id}/quarantine", quarantine, R"({"reason":"x"})").status, 403);
  EXPECT_EQ(Ok(Call(op, "POST", "rigs/{id}/quarantine", quarantine, R"({"reason":"smells"})"))
                .at("status"),
            "quarantined");
  EXPECT_EQ(Call(op, "POST", "rigs/{id}/self-test", "rigs/bench-1/self-test", "{}").status, 409);
  Ok(Call(op, "POST", "rigs/{id}/release", "rigs/bench-1/release", "{}"));
  WaitForBenches(2);
  Ok(Call(op, "POST", "rigs/{id}/self-test", "rigs/bench-1/self-test", "{}"));
  WaitForBenches(2);
  const json::object outage =
      Ok(Call(op,
              "POST",
              "rigs/{id}/outages",
              "rigs/bench-2/outages",
              json::serialize(json::object{{"start", In(std::chrono::minutes(10))},
                                           {"end", In(std::chrono::minutes(70))},
                                           {"reason", "new brushes"}})),
         201);
  EXPECT_EQ(Ok(Call(ann, "GET", "rigs/{id}/health", "rigs/bench-2/health"))
                .at("outages")
                .as_array()
                .size(),
            1u);
  const std::string path = "rigs/bench-2/outages/" + std::to_string(outage.at("id").as_int64());
  EXPECT_EQ(Call(op, "DELETE", "rigs/{id}/outages/{outage}", path).status, 204);
  EXPECT_EQ(Call(op, "DELETE", "rigs/{id}/outages/{outage}", path).status, 404);
  EXPECT_EQ(Call(op, "GET", "rigs/{id}/health", "rigs/unicorn/health").status, 404);
}

TEST_F(LabApiTest, AnInstructorTakesOverStudentsOfOwnCoursesOnlyAndWithAReason) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const Person other = Make("other-teacher", Role::kInstructor);
  const Person ann = Make("ann", Role::kStudent);
  const Account account = accounts_->GetByLogin("teacher").value();
  const Course course = accounts_->CreateCourse("c", account.id, Now()).value();
  ASSERT_TRUE(accounts_->Enrol(course.id, accounts_->GetByLogin("ann").value().id, false).ok());
  WaitForBenches(2);
  const json::object ticket =
      Ok(Call(ann, "POST", "tickets", "tickets", R"({"rig_class":"bench"})"), 201);
  const std::string ticket_id = std::to_string(ticket.at("ticket").at("id").as_int64());
  const json::object session =
      Ok(Call(ann, "POST", "tickets/{id}/accept", "tickets/" + ticket_id + "/accept", "{}"));
  const std::string path = "sessions/" + std::to_string(session.at("id").as_int64()) + "/take-over";
  const std::string why = R"({"reason":"the motor screams"})";
  const auto seen = [&](const Person& who) {
    return Ok(Call(who, "GET", "sessions", "sessions?all=1")).at("items").as_array();
  };
  ASSERT_EQ(seen(teacher).size(), 1u);
  EXPECT_EQ(seen(teacher)[0].at("user"), "ann");
  EXPECT_FALSE(seen(teacher)[0].as_object().contains("run")) << "nothing runs";
  EXPECT_TRUE(seen(other).empty()) << "not a student of theirs";
  EXPECT_EQ(Call(ann, "GET", "sessions", "sessions?all=1").status, 403);

  const std::string rig(session.at("rig").as_string());
  const json::object run =
      Ok(Call(ann,
              "POST",
              "runs",
              "runs",
              json::serialize(json::object{{"rig", rig}, {"duration_s", 600}})),
         201);
  json::array with_run = seen(teacher);
  for (int i = 0; i < 5000 && !with_run.at(0).at("run_in_progress").as_bool(); ++i) {
    with_run = seen(teacher);
  }
  ASSERT_TRUE(with_run.at(0).as_object().contains("run")) << with_run;
  EXPECT_EQ(with_run[0].at("run"), run.at("id"));
  const std::string watched = "runs/" + std::string(run.at("id").as_string());
  EXPECT_EQ(Call(teacher, "GET", "runs/{id}", watched).status, 200);
  EXPECT_EQ(Call(other, "GET", "runs/{id}", watched).status, 404);
  EXPECT_EQ(Call(teacher, "DELETE", "runs/{id}", watched).status, 403) << "watching is reading";
  const auto hello = [&](const Person& who) {
    const json::object token =
        Ok(Call(who, "POST", "runs/{id}/stream-token", watched + "/stream-token", "{}"), 201);
    tests::WebSocketClient page(laboratory_->port(),
                                "/ws?code=" + std::string(token.at("code").as_string()));
    return json::parse(page.ReadTextWith("\"hello\"").value_or("{}")).as_object();
  };
  EXPECT_TRUE(hello(ann).at("can_command").as_bool());
  EXPECT_FALSE(hello(teacher).at("can_command").as_bool()) << "without taking over";
  EXPECT_EQ(Call(other, "POST", "sessions/{id}/take-over", path, why).status, 404);
  EXPECT_EQ(Call(ann, "POST", "sessions/{id}/take-over", path, why).status, 403);
  EXPECT_EQ(Call(teacher, "POST", "sessions/{id}/take-over", path, R"({"reason":""})").status, 400);
  EXPECT_EQ(Ok(Call(teacher, "POST", "sessions/{id}/take-over", path, why)).at("user"), "teacher");
}

TEST_F(LabApiTest, FaultSetsAreSharedInACourseImmutableOnceUsedAndHiddenWhenTold) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const Person ann = Make("ann", Role::kStudent);
  const Person stranger = Make("stranger", Role::kStudent);
  const Course course =
      accounts_->CreateCourse("c", accounts_->GetByLogin("teacher").value().id, Now()).value();
  ASSERT_TRUE(accounts_->Enrol(course.id, accounts_->GetByLogin("ann").value().id, false).ok());
  json::object wanted{{"name", "Verstärker"},
                      {"course", course.id},
                      {"faults", json::parse(R"([{"component":"R9","value":27000,"at_s":1}])")}};
  EXPECT_EQ(Call(ann, "POST", "fault-sets", "fault-sets", json::serialize(wanted)).status, 403);
  const json::object made =
      Ok(Call(teacher, "POST", "fault-sets", "fault-sets", json::serialize(wanted)), 201);
  const std::string id = std::to_string(made.at("id").as_int64());
  const auto listed = [&](const Person& who) {
    return Ok(Call(who, "GET", "fault-sets", "fault-sets")).at("items").as_array().size();
  };
  EXPECT_EQ(listed(ann), 1u);
  EXPECT_EQ(listed(stranger), 0u);
  const std::string run = R"({"duration_s":2,"fault_set":)" + id + "}";
  EXPECT_EQ(Call(stranger, "POST", "runs", "runs", run).status, 400);
  const json::object started = Ok(Call(ann, "POST", "runs", "runs", run), 201);
  EXPECT_EQ(started.at("plan").at("faults").at(0).at("component"), "R9");

  wanted["visible"] = false;
  const json::object next = Ok(Call(teacher,
                                    "PUT",
                                    "fault-sets/{id}",
                                    "fault-sets/" + id,
                                    json::serialize(wanted),
                                    "If-Match: \"1\"\r\n"));
  EXPECT_NE(next.at("id"), made.at("id")) << "the used one stays as it was";
  EXPECT_EQ(next.at("replaces"), made.at("id"));
  EXPECT_EQ(next.at("version"), 2);
  EXPECT_EQ(listed(ann), 0u) << "hidden";
  EXPECT_EQ(listed(teacher), 1u);
  const std::string next_path = "fault-sets/" + std::to_string(next.at("id").as_int64());
  EXPECT_EQ(Call(ann, "DELETE", "fault-sets/{id}", next_path, {}, "If-Match: \"2\"\r\n").status,
            403);
  EXPECT_EQ(Call(teacher, "DELETE", "fault-sets/{id}", next_path, {}, "If-Match: \"2\"\r\n").status,
            204);
  const json::object bad{{"name", "x"},
                         {"faults", json::parse(R"([{"component":"R99","value":1}])")}};
  EXPECT_EQ(Call(teacher, "POST", "fault-sets", "fault-sets", json::serialize(bad)).status, 400);
}

TEST_F(LabApiTest, ABatchOfJobsRunsToItsResultsAndABadRunIsNamedBeforehand) {
  const Person ann = Make("ann", Role::kStudent);
  const std::string bad = R"({"runs":[{"duration_s":2},{"duration_s":99999}]})";
  const HttpAnswer refused = Call(ann, "POST", "jobs", "jobs", bad);
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(json::parse(refused.body).at("field"), "/runs/1/duration_s");
  const std::string good =
      R"({"name":"sweep","runs":[{"duration_s":2},{"duration_s":2,"seed":2},{"duration_s":2,"seed":3}]})";
  const json::object batch =
      Ok(Call(ann, "POST", "jobs", "jobs", good, "Idempotency-Key: sweep-1\r\n"), 202);
  const std::string again =
      Call(ann, "POST", "jobs", "jobs", good, "Idempotency-Key: sweep-1\r\n").body;
  EXPECT_EQ(json::parse(again).at("batch"), batch.at("batch"));
  const std::string list = "jobs?batch=" + std::string(batch.at("batch").as_string());
  json::array items;
  const auto done = [&] {
    items = Ok(Call(ann, "GET", "jobs", list)).at("items").as_array();
    return std::all_of(items.begin(), items.end(), [](const json::value& job) {
      return job.at("state") == "finished" || job.at("state") == "failed";
    });
  };
  for (int i = 0; i < 3000 && !done(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_EQ(items.size(), 3u);
  for (const json::value& job : items) {
    EXPECT_EQ(job.at("state"), "finished") << json::serialize(job);
    const std::string run(job.at("run").as_string());
    EXPECT_EQ(Ok(Call(ann, "GET", "runs/{id}", "runs/" + run)).at("samples"), 200);
  }
  const std::string first = "jobs/" + std::string(items[0].at("id").as_string());
  EXPECT_EQ(Ok(Call(ann, "GET", "jobs/{id}", first)).at("progress"), 1.0);
  EXPECT_EQ(Call(ann, "DELETE", "jobs/{id}", first).status, 409);
  const Person bob = Make("bob", Role::kStudent);
  EXPECT_EQ(Call(bob, "GET", "jobs/{id}", first).status, 404);
}

TEST_F(LabApiTest, TheExampleClientsSweepAndSaveTheirData) {
  const auto account = accounts_->Create("robot", "Robot", Role::kStudent, Now()).value();
  Principal who;
  who.user_id = account.id;
  const auto key =
      accounts_->CreateKey(who, "k", {"jobs", "runs:read"}, Now() + std::chrono::hours(1), Now());
  const std::string url = "http://" + laboratory_->address();
  const std::string examples = FAULTLAB_SOURCE_DIR "/deploy/examples/";
  const std::string sweep = "cd " + folder_.path().string() + " && python3 " + examples +
                            "client.py --url " + url + " --key " + key.value().secret +
                            " --component R9 --values 27000,56000 > sweep.txt 2> sweep.err";
  EXPECT_EQ(std::system(sweep.c_str()), 0) << ReadText(folder_.File("sweep.err"));
  const std::string table = ReadText(folder_.File("sweep.txt"));
  EXPECT_NE(table.find("27000\tfault"), std::string::npos) << table;
  EXPECT_NE(table.find("56000\tfault"), std::string::npos) << table;
  EXPECT_NE(ReadText(folder_.File("R9-27000.csv")).find("t_s,uc_v,um_v"), std::string::npos);

  const std::string one = "cd " + folder_.path().string() + " && sh " + examples + "client.sh " +
                          url + " " + key.value().secret + " R1 100 > one.json 2> one.err";
  EXPECT_EQ(std::system(one.c_str()), 0) << ReadText(folder_.File("one.err"));
  EXPECT_EQ(json::parse(ReadText(folder_.File("one.json"))).at("verdict"), "fault");
}

/// Values of every kind but the right one, and too much of the right one.
json::array BadValues() {
  return {nullptr,
          true,
          -1,
          1e300,
          "",
          "\xF0\x9F\x92\xA9 \xE2\x80\xAE",
          std::string(70'000, 'x'),
          json::array{json::array{1}},
          json::object{{"a", json::object{}}}};
}

std::string WithExamples(std::string path) {
  for (std::size_t open = path.find('{'); open != std::string::npos; open = path.find('{')) {
    path.replace(open, path.find('}') - open + 1, "1");
  }
  return path;
}

TEST_F(LabApiTest, EveryOperationAnswersGeneratedBadInputWithAProblemAndLivesOn) {
  const Person admin = Admin();
  int tried = 0;
  for (const auto& path : description_.document().at("paths").as_object()) {
    const std::string pattern(path.key());
    if (!pattern.starts_with(kApi)) continue;
    for (const auto& entry : path.value().as_object()) {
      std::string method(entry.key());
      std::transform(method.begin(), method.end(), method.begin(), [](char c) {
        return static_cast<char>(std::toupper(c));
      });
      const std::string below = pattern.substr(std::string(kApi).size());
      const std::string target = WithExamples(below);
      // The sign-out would end the test's own sign-in; a stored run would be made by the thousand.
      if (below == "auth/logout" || below == "runs") continue;
      const auto send = [&](const std::string& where, const std::string& body) {
        const HttpAnswer answer = Call(admin, method, below, where, body, "If-Match: \"1\"\r\n");
        EXPECT_NE(answer.status, 0) << method << " " << where << " " << body.substr(0, 80);
        EXPECT_TRUE(answer.status < 500 || answer.status == 503)
            << method << " " << where << " " << answer.status << " " << body.substr(0, 80);
        ++tried;
        return answer.status;
      };
      for (const char* query : {"?limit=0", "?limit=x", "?unknown=1", "?cursor=%00", "?since=-1"}) {
        if (method == "GET") send(target + query, {});
      }
      const json::object& operation = entry.value().as_object();
      if (!operation.contains("requestBody")) continue;
      const json::object& content = operation.at("requestBody").at("content").as_object();
      if (!content.contains("application/json")) continue;
      const json::value* example =
          content.at("application/json").as_object().if_contains("example");
      const json::object good =
          example != nullptr && example->is_object() ? example->as_object() : json::object{};
      EXPECT_GE(send(target, "{"), 400);
      EXPECT_GE(send(target, "[]"), 400);
      json::object unknown = good;
      unknown["no_such_field"] = 1;
      EXPECT_GE(send(target, json::serialize(unknown)), 400) << below;
      for (const auto& member : good) {
        for (const json::value& bad : BadValues()) {
          if (bad.kind() == member.value().kind() && !bad.is_string()) continue;
          json::object broken = good;
          broken[member.key()] = bad;
          send(target, json::serialize(broken));
        }
      }
    }
  }
  EXPECT_GT(tried, 400);
  EXPECT_EQ(tests::Get(laboratory_->port(), "/healthz").status, 200);
}

TEST_F(LabApiTest, TwoHundredClientsWhoAskInTheSameSecondAllGetAConsistentPlace) {
  constexpr int kClients = 200;
  std::vector<Person> people;
  for (int i = 0; i < kClients; ++i) {
    const auto account =
        accounts_->Create("student" + std::to_string(i), "S", Role::kStudent, Now()).value();
    Principal who;
    who.user_id = account.id;
    const auto key =
        accounts_->CreateKey(who, "k", {"lab"}, Now() + std::chrono::hours(1), Now()).value();
    people.push_back(
        {"Authorization: Bearer " + key.secret + "\r\nContent-Type: application/json\r\n"});
  }
  WaitForBenches(2);
  std::vector<double> took_ms(kClients);
  std::vector<int> status(kClients);
  std::vector<std::thread> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.emplace_back([&, i] {
      const auto index = static_cast<std::size_t>(i);
      const auto start = std::chrono::steady_clock::now();
      status[index] = tests::Request(laboratory_->port(),
                                     "POST",
                                     "/api/v1/tickets",
                                     people[index].headers,
                                     R"({"rig_class":"bench"})")
                          .status;
      took_ms[index] =
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
              .count();
    });
  }
  for (auto& client : clients) client.join();
  EXPECT_EQ(std::count(status.begin(), status.end(), 201), kClients);
  std::set<std::int64_t> places;
  int waiting = 0;
  for (const Person& person : people) {
    const HttpAnswer mine =
        tests::Request(laboratory_->port(), "GET", "/api/v1/tickets", person.headers);
    const json::value list = json::parse(mine.body);
    ASSERT_EQ(list.at("items").as_array().size(), 1u);
    const json::value& ticket = list.at("items").at(0);
    if (ticket.at("state") != "waiting") continue;
    ++waiting;
    places.insert(ticket.at("place").as_int64());
  }
  ASSERT_EQ(static_cast<int>(places.size()), waiting) << "no place is given twice";
  EXPECT_EQ(*places.begin(), 1);
  EXPECT_EQ(*places.rbegin(), waiting);
  std::sort(took_ms.begin(), took_ms.end());
  std::printf("200 clients in one second: p50 %.0f ms, p99 %.0f ms\n", took_ms[100], took_ms[197]);
}

TEST(Times, AreInstantsOrRefused) {
  const auto parse = [](const char* text) { return ParseIso8601(text, "t"); };
  const WallTime noon = parse("2026-11-21T12:00:00Z").value();
  EXPECT_EQ(parse("2026-11-21T13:00:00+01:00").value(), noon);
  EXPECT_EQ(parse("2026-11-21T06:30:00.000-05:30").value(), noon);
  EXPECT_EQ(parse("2026-11-21T12:00Z").value(), noon);
  // The hour that happens twice in Berlin is two different instants, an hour apart.
  EXPECT_EQ(parse("2026-10-25T02:30:00+01:00").value() - parse("2026-10-25T02:30:00+02:00").value(),
            std::chrono::hours(1));
  EXPECT_EQ(Iso8601(parse("2024-02-29T23:59:59.999Z").value()), "2024-02-29T23:59:59.999Z");
  for (const char* bad : {"",
                          "tomorrow",
                          "2026-11-21",
                          "2026-11-21T12:00:00",
                          "2026-11-21 12:00:00Z",
                          "2026-03-29T02:30:00 Europe/Berlin",
                          "2026-02-29T12:00:00Z",
                          "2026-13-01T12:00:00Z",
                          "2026-11-21T24:00:00Z",
                          "2026-11-21T12:00:00+25:00",
                          "2026-11-21T12:00:00.Z",
                          "2026-11-21T12:00:00Zx",
                          "99999-11-21T12:00:00Z"}) {
    EXPECT_FALSE(parse(bad).ok()) << bad;
  }
}

TEST_F(LabApiTest, TellsAListenerItsPlaceAndItsSessionWithoutBeingAsked) {
  WaitForBenches(2);
  const Person ann = Make("ann", Role::kStudent);
  const Person ben = Make("ben", Role::kStudent);
  const Person eve = Make("eve", Role::kStudent);
  const auto listen = [&](const Person& who) {
    const HttpAnswer answer = Call(who, "POST", "events/stream-token", "events/stream-token", "{}");
    const std::string code(Ok(answer, 201).at("code").as_string());
    return std::make_unique<tests::WebSocketClient>(laboratory_->port(), "/ws?code=" + code);
  };
  const auto next = [](tests::WebSocketClient& page) {
    const auto text = page.ReadTextWith("\"lab\"");
    EXPECT_TRUE(text) << "the feed has ended";
    return text ? json::parse(*text).as_object() : json::object{};
  };
  const auto page = listen(eve);
  const json::object first = next(*page);
  EXPECT_TRUE(first.at("tickets").as_array().empty());
  EXPECT_TRUE(first.at("sessions").as_array().empty());
  EXPECT_TRUE(first.at("news").as_array().empty());

  const std::string wish = R"({"rig_class":"bench","min_s":600,"want_s":1800})";
  for (const Person* taker : {&ann, &ben}) {
    Ok(Call(*taker, "POST", "tickets", "tickets", wish), 201);
  }
  Ok(Call(eve, "POST", "tickets", "tickets", wish), 201);
  json::object told;
  do {
    told = next(*page);
  } while (!told.empty() && told.at("tickets").as_array().empty());
  EXPECT_EQ(told.at("tickets").at(0).at("place").as_int64(), 1);

  // One ends: the waiting one is offered the bench after its check, and hears of it.
  const json::array held = Ok(Call(ann, "GET", "sessions", "sessions")).at("items").as_array();
  ASSERT_EQ(held.size(), 1u);
  const std::string id = std::to_string(held[0].at("id").as_int64());
  Ok(Call(ann, "POST", "sessions/{id}/end", "sessions/" + id + "/end", "{}"), 204);
  bool news = false;
  do {
    told = next(*page);
    news = news || (!told.empty() && !told.at("news").as_array().empty());
  } while (!told.empty() && told.at("sessions").as_array().empty());
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.at("sessions").at(0).at("state"), "held");
  EXPECT_TRUE(news) << "an offer is news";

  // Nothing of another person comes here, and who is not signed in has no feed.
  EXPECT_EQ(json::serialize(told).find("ann"), std::string::npos);
  EXPECT_EQ(Call({}, "POST", "events/stream-token", "events/stream-token", "{}").status, 401);
}

}  // namespace
}  // namespace faultlab::server
