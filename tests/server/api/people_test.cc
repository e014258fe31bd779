// Accounts, courses, keys, rigs and the description over HTTP.
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <map>
#include <set>

#include "server/api/iso8601.h"
#include "server/storage/rows.h"
#include "tests/server/api/api_world.h"
#include "tests/support/await.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;

std::string Lower(HttpMethod method) {
  std::string name(Name(method));
  std::transform(name.begin(), name.end(), name.begin(), [](char c) {
    return static_cast<char>(std::tolower(c));
  });
  return name;
}
/// "name=value" of the answer's Set-Cookie lines.
std::string CookieOf(const HttpAnswer& answer, const std::string& name) {
  for (const auto& [header, value] : answer.headers) {
    const bool is = header == "Set-Cookie" && value.starts_with(name + "=");
    if (is) return value.substr(0, value.find(';'));
  }
  return {};
}

TEST_F(ApiTest, EveryRouteIsDescribedAndEveryDescribedOperationHasARoute) {
  std::set<std::string> routes;
  const std::set<std::string> outside = {"/healthz", "/readyz", "/metrics"};
  for (const Route& route : application_->router().routes()) {
    const bool of_the_api = route.pattern.starts_with("/api/") || outside.contains(route.pattern);
    if (of_the_api) routes.insert(Lower(route.method) + " " + route.pattern);
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

TEST_F(ApiTest, AnAdminMakesPeopleCoursesAndKeysAndTheLogKeepsIt) {
  const Person admin = Admin();
  const json::object ann =
      Ok(Call(admin, "POST users", R"({"login":"ann","name":"Ann Ångström 名"})"), 201);
  const std::string ann_id = Id(ann);
  const json::object link = Ok(Call(admin, "POST users/" + ann_id + "/reset-link", "{}"), 201);
  const std::string path = Text(link, "link");
  const std::string token = path.substr(path.find('=') + 1);
  EXPECT_EQ(Call(kNobody,
                 "POST auth/reset",
                 json::serialize(json::object{{"token", token}, {"password", kPassword}}))
                .status,
            204);
  const Person student = ByPassword("ann");

  const HttpAnswer stale =
      Call(admin, "PATCH users/" + ann_id, R"({"role":"instructor"})", IfMatch(7));
  EXPECT_EQ(stale.status, 409);
  EXPECT_EQ(Call(admin, "PATCH users/" + ann_id, R"({"role":"instructor"})").status, 400);
  Ok(Call(admin, "PATCH users/" + ann_id, R"({"role":"instructor"})", IfMatch(1)));
  const json::object course =
      Ok(Call(student, "POST courses", R"({"name":"Regelungstechnik Ω"})"), 201);
  const std::string members = "courses/" + Id(course) + "/members";
  const json::object enrolled =
      Ok(Call(student, "POST " + members, "login,name\nbob,Bob\ncem,Cem\n", kCsv));
  EXPECT_EQ(enrolled.at("enrolled"), 2);
  EXPECT_EQ(Items(student, members).size(), 3u);

  const json::object key =
      Ok(Call(student,
              "POST api-keys",
              json::serialize(json::object{{"name", "robot"},
                                           {"scopes", json::array{"runs:read"}},
                                           {"expires_at", In(std::chrono::hours(24))}})),
         201);
  const Person robot{"Authorization: Bearer " + Text(key, "key") + "\r\n"};
  EXPECT_EQ(Ok(Call(robot, "GET auth/me")).at("role"), "service");
  const json::object run = Ok(Call(student, "POST runs", R"({"rig":"sim-1","duration_s":2})"), 201);
  const std::string run_path = "runs/" + Id(run);
  const auto star = [&](const Person& who) {
    return Call(who, "PATCH " + run_path, R"({"starred":true})").status;
  };
  EXPECT_EQ(star(robot), 403) << "it only reads";
  EXPECT_EQ(star(student), 200);
  const std::string key_path = "api-keys/" + Id(key);
  EXPECT_EQ(Call(student, "DELETE " + key_path).status, 204);
  EXPECT_EQ(Call(robot, "GET auth/me").status, 401);

  std::set<std::string> verbs;
  const json::object log = Ok(Call(admin, "GET audit?limit=100"));
  for (const auto& entry : log.at("items").as_array()) {
    verbs.insert(Text(entry, "verb"));
    if (entry.at("verb") == "create_user") {
      EXPECT_EQ(entry.at("actor_login"), "admin");
      EXPECT_EQ(entry.at("object_login"), "ann");
    }
  }
  for (const char* verb : {"create_user",
                           "reset_link",
                           "use_reset_link",
                           "sign_in",
                           "change_user",
                           "create_course",
                           "enrol",
                           "create_key",
                           "revoke_key"}) {
    EXPECT_TRUE(verbs.contains(verb)) << verb;
  }
  EXPECT_EQ(Call(admin, "POST auth/logout", "{}").status, 204);
  EXPECT_EQ(Call(admin, "GET users").status, 401);
}

TEST_F(ApiTest, ARefusedSignInTellsNotWhichLoginsThereAre) {
  Make("ann", Role::kStudent);
  const auto answer = [&](const std::string& login) {
    return Call(kNobody,
                "POST auth/login",
                json::serialize(json::object{{"login", login}, {"password", "wrong password"}}));
  };
  const HttpAnswer known = answer("ann");
  const HttpAnswer unknown = answer("nobody");
  EXPECT_EQ(known.status, 401);
  EXPECT_EQ(unknown.status, known.status);
  EXPECT_EQ(unknown.body, known.body);
}

TEST_F(ApiTest, GuessingIsAnsweredWith429AndWithWhenToComeBack) {
  Make("ann", Role::kStudent);
  const auto sign_in = [&](const std::string& password, const std::string& headers = "") {
    return Call(kNobody,
                "POST auth/login",
                json::serialize(json::object{{"login", "ann"}, {"password", password}}),
                headers);
  };
  const HttpAnswer right = sign_in(kPassword);
  const std::string device = CookieOf(right, "faultlab_device");
  ASSERT_FALSE(device.empty());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(sign_in("wrong password").status, 401);
  // The wait begins at 1 s and doubles: a slow machine may miss the first ones.
  HttpAnswer refused;
  for (int i = 0; i < 8 && refused.status != 429; ++i) refused = sign_in("wrong password");
  EXPECT_EQ(refused.status, 429) << refused.body;
  EXPECT_GE(std::stoi(std::string(refused.Header("Retry-After"))), 1);
  EXPECT_EQ(ReasonOf(refused), "sign_in_throttled");
  EXPECT_EQ(sign_in(kPassword, "Cookie: " + device + "\r\n").status, 200)
      << "a browser that signed in before";
}

TEST_F(ApiTest, WhoLeavesAndWhoDeletesIsWrittenDown) {
  const Person admin = Admin();
  const Person teacher = Make("teacher", Role::kInstructor);
  const Person ann = Make("ann", Role::kStudent);
  const Course course = MakeCourse("teacher", "ann");
  const auto member = [&](const std::string& login) {
    return "courses/" + std::to_string(course.id) + "/members/" + std::to_string(AccountOf(login));
  };
  EXPECT_EQ(Call(ann, "DELETE " + member("ann")).status, 403);
  EXPECT_EQ(Call(teacher, "DELETE " + member("teacher")).status, 409);
  EXPECT_EQ(Call(teacher, "DELETE " + member("ann")).status, 204);
  EXPECT_EQ(Call(teacher, "DELETE " + member("ann")).status, 404);
  Ok(Call(ann, "POST calendar-link", "{}"), 201);
  EXPECT_EQ(Call(ann, "DELETE calendar-link").status, 204);
  const json::object run = Ok(Call(ann, "POST runs", R"({"duration_s":1,"rig":"sim-1"})"), 201);
  const std::string id = Id(run);
  HttpAnswer deleted;
  EXPECT_TRUE(tests::Await([&] {
    deleted = Call(ann, "DELETE runs/" + id);
    return deleted.status != 409;
  }));
  EXPECT_EQ(deleted.status, 204) << deleted.body;
  EXPECT_EQ(Call(ann, "POST auth/logout", "{}").status, 204);
  std::set<std::string> seen;
  const json::object log = Ok(Call(admin, "GET audit?limit=100"));
  for (const auto& entry : log.at("items").as_array()) {
    seen.insert(Text(entry, "actor_login") + " " + Text(entry, "verb") + " " +
                Text(entry, "object"));
    if (entry.at("verb") == "delete_run") {
      EXPECT_EQ(entry.at("object_login"), "ann");
    }
    if (entry.at("verb") == "end_enrolment") {
      EXPECT_EQ(entry.at("detail").as_string(), course.name);
    }
  }
  const std::string key = "user:" + std::to_string(AccountOf("ann"));
  for (const std::string& line : {"teacher end_enrolment " + key,
                                  "ann create_calendar_link " + key,
                                  "ann remove_calendar_link " + key,
                                  "ann delete_run run:" + id,
                                  "ann sign_out " + key}) {
    EXPECT_TRUE(seen.contains(line)) << line;
  }
}

TEST_F(ApiTest, AKeyOfAnAdminManagesPeopleButNoAdmins) {
  const Person admin = Admin();
  const Person student = Make("ann", Role::kStudent);
  const auto wanted = [&](const char* scope) {
    return json::serialize(json::object{{"name", "script"},
                                        {"scopes", json::array{scope}},
                                        {"expires_at", In(std::chrono::hours(24))}});
  };
  EXPECT_EQ(Call(student, "POST api-keys", wanted("people")).status, 403);
  const auto key_of = [&](const char* scope) {
    const json::object key = Ok(Call(admin, "POST api-keys", wanted(scope)), 201);
    return Person{"Authorization: Bearer " + Text(key, "key") + "\r\n"};
  };
  const Person script = key_of("people");
  const json::object made =
      Ok(Call(script, "POST users", R"({"login":"bea","role":"instructor"})"), 201);
  const std::string bea = "users/" + Id(made);
  Ok(Call(script, "POST " + bea + "/reset-link", "{}"), 201);
  EXPECT_EQ(Call(key_of("operate"), "POST users", R"({"login":"x12"})").status, 403);

  const std::string chief = "users/" + std::to_string(AccountOf("admin"));
  EXPECT_EQ(Call(script, "POST " + chief + "/reset-link", "{}").status, 403);
  EXPECT_EQ(Call(script, "POST users", R"({"login":"eve","role":"admin"})").status, 403);
  const auto change = [&](const std::string& who, const char* body) {
    return Call(script, "PATCH " + who, body, IfMatch(1)).status;
  };
  EXPECT_EQ(change(bea, R"({"role":"admin"})"), 403);
  EXPECT_EQ(change(chief, R"({"disabled":true})"), 403);
  EXPECT_EQ(change(bea, R"({"role":"operator"})"), 200);
  EXPECT_EQ(Call(script, "POST api-keys", wanted("people")).status, 403);
}

TEST_F(ApiTest, AnInstructorReadsNobodysRunsByEnrollingTheirLogin) {
  const Person admin = Admin();
  const Person curious = Make("curious", Role::kInstructor);
  const Person other = Make("other", Role::kInstructor);
  const Person ann = Make("ann", Role::kStudent);
  const auto run_of = [&](const Person& who) {
    const json::object run = Ok(Call(who, "POST runs", R"({"duration_s":1})"), 201);
    return "runs/" + Id(run);
  };
  const std::string run_of_ann = run_of(ann);
  const std::string run_of_other = run_of(other);
  const auto reads = [&](const std::string& run) {
    return Call(curious, "GET " + run).status == 200;
  };
  const json::object course = Ok(Call(curious, "POST courses", R"({"name":"Mine"})"), 201);
  const std::string id = Id(course);
  const json::object asked = Ok(Call(curious,
                                     "POST courses/" + id + "/members",
                                     "ann,Ann\nother,Other\nadmin,Admin\nfresh,Fresh\n",
                                     kCsv));
  EXPECT_EQ(asked.at("enrolled"), 1);
  EXPECT_EQ(asked.at("invited"), 3);
  EXPECT_EQ(asked.at("members_already"), 0);
  EXPECT_FALSE(reads(run_of_ann));
  EXPECT_FALSE(reads(run_of_other));

  const auto mine = Items(ann, "invitations");
  ASSERT_EQ(mine.size(), 1u);
  EXPECT_EQ(mine[0].at("course_name"), "Mine");
  EXPECT_EQ(mine[0].at("invited_by"), "curious");
  const auto answer = [&](const Person& who, const std::string& word) {
    return Call(who, "POST invitations/" + id + "/" + word, "{}").status;
  };
  EXPECT_EQ(answer(ann, "accept"), 204);
  EXPECT_EQ(answer(ann, "accept"), 404) << "answered already";
  EXPECT_EQ(answer(other, "decline"), 204);
  EXPECT_EQ(answer(curious, "accept"), 404) << "nobody asked the teacher";
  EXPECT_FALSE(reads(run_of_ann)) << "made before she joined";
  EXPECT_TRUE(reads(run_of(ann)));
  EXPECT_FALSE(reads(run_of_other));
  const std::string waiting = "courses/" + id + "/invitations";
  const json::object left = Ok(Call(curious, "GET " + waiting));
  ASSERT_EQ(left.at("items").as_array().size(), 1u);
  EXPECT_EQ(left.at("items").at(0).at("login"), "admin");
  EXPECT_EQ(Call(other, "GET " + waiting).status, 404);

  std::map<std::string, std::string> details;
  const json::object log = Ok(Call(admin, "GET audit?limit=100"));
  for (const auto& entry : log.at("items").as_array()) {
    details[Text(entry, "verb")] = Text(entry, "detail");
  }
  EXPECT_EQ(details["enrol"], "fresh");
  EXPECT_EQ(details["invite"], "ann, other, admin");
}

TEST_F(ApiTest, AChangeByCookieWithoutTheTokenOfThePageIsRefused) {
  Person ann = Make("ann", Role::kStudent);
  ann.headers = ann.headers.substr(0, ann.headers.find("X-CSRF"));
  EXPECT_EQ(Call(ann, "GET tickets").status, 200);
  EXPECT_EQ(Call(ann, "POST tickets", R"({"rig_class":"bench"})").status, 403);
}

TEST_F(ApiTest, TheSameKeyIsDoneOnceAndAnotherRequestWithItIsRefused) {
  const Person ann = Make("ann", Role::kStudent);
  WaitForBenches(2);
  const std::string key = "Idempotency-Key: abc\r\n";
  const json::object wanted{{"rig_class", "bench"},
                            {"start", In(std::chrono::minutes(60))},
                            {"end", In(std::chrono::minutes(90))}};
  const std::string body = json::serialize(wanted);
  const HttpAnswer first = Call(ann, "POST bookings", body, key);
  const HttpAnswer second = Call(ann, "POST bookings", body, key);
  EXPECT_EQ(first.status, 201);
  EXPECT_EQ(second.status, 201);
  EXPECT_EQ(first.body, second.body);
  EXPECT_EQ(second.Header("Idempotency-Replayed"), "true");
  EXPECT_EQ(Items(ann, "bookings").size(), 1u);
  EXPECT_EQ(Call(ann, "POST tickets", R"({"rig_class":"bench"})", key).status, 409);
}

TEST_F(ApiTest, ARefusalIsTriedAgainAndASecretIsToldOnce) {
  const Person ann = Make("ann", Role::kStudent);
  const auto post = [&](const std::string& path, const std::string& body, const std::string& key) {
    return Call(ann, "POST " + path, body, "Idempotency-Key: " + key + "\r\n");
  };
  EXPECT_EQ(post("runs", R"({"rig":"unicorn"})", "one").status, 404);
  const std::string plan = R"({"rig":"sim-1","duration_s":600})";
  const HttpAnswer first = post("runs", plan, "one");
  EXPECT_EQ(first.status, 201) << "the refusal has done nothing: " << first.body;
  const HttpAnswer again = post("runs", plan, "one");
  EXPECT_EQ(again.body, first.body);
  EXPECT_EQ(Items(ann, "runs").size(), 1U) << "a script that tries again has one run";

  const std::string key = json::serialize(json::object{
      {"name", "k"}, {"scopes", json::array{"lab"}}, {"expires_at", In(std::chrono::hours(24))}});
  EXPECT_EQ(post("api-keys", key, "two").status, 201);
  const HttpAnswer second = post("api-keys", key, "two");
  EXPECT_EQ(second.status, 409);
  EXPECT_EQ(Ok(second, 409).at("reason"), "answer_told_once");
  EXPECT_EQ(Items(ann, "api-keys").size(), 1U);
  const core::Status searched = database_->Read([&](Transaction& tx) -> core::Status {
    EXPECT_EQ(CountRows(tx, "remembered_answer WHERE body LIKE '%flk_%'"), 0);
    return core::Done{};
  });
  EXPECT_TRUE(searched.ok());
}

TEST_F(ApiTest, APasswordLeavesNothingToGuessIt) {
  const Person ann = Make("ann", Role::kStudent);
  const std::string body =
      json::serialize(json::object{{"old", kPassword}, {"new", "staple of another horse"}});
  const HttpAnswer changed = Call(ann, "POST auth/password", body, "Idempotency-Key: p\r\n");
  EXPECT_LT(changed.status, 300) << changed.body;
  const core::Result<std::int64_t> kept =
      database_->Read([](Transaction& tx) -> core::Result<std::int64_t> {
        return CountRows(tx, "remembered_answer");
      });
  EXPECT_EQ(kept.value(), 0);
}

TEST_F(ApiTest, WhoPollsIsToldOnlyWhatHasChanged) {
  const Person ann = Make("ann", Role::kStudent);
  const HttpAnswer first = Call(ann, "GET tickets");
  const std::string tag = first.Header("ETag");
  ASSERT_TRUE(tag.starts_with("W/\"")) << tag;
  const auto ask = [&] {
    return tests::Request(application_->port(),
                          "GET",
                          "/api/v1/tickets",
                          ann.headers + "If-None-Match: " + tag + "\r\n");
  };
  const HttpAnswer same = ask();
  EXPECT_EQ(same.status, 304);
  EXPECT_EQ(same.body, "");
  EXPECT_EQ(same.Header("ETag"), tag);
  Ok(Call(ann, "POST tickets", R"({"rig_class":"bench"})"), 201);
  EXPECT_EQ(ask().status, 200);
}

TEST_F(ApiTest, AnOperatorTakesRigsOutAndBringsThemBackThroughACheck) {
  const Person op = Make("operator1", Role::kOperator);
  const Person ann = Make("ann", Role::kStudent);
  WaitForBenches(2);
  const std::string quarantine = "rigs/bench-1/quarantine";
  for (const char* blank : {R"({"reason":""})", R"({"reason":"  "})"}) {
    EXPECT_EQ(Ok(Call(op, "POST " + quarantine, blank), 400).at("reason"), "reason_missing");
  }
  EXPECT_EQ(Ok(Call(op, "POST " + quarantine, R"({"reason":"smells"})")).at("status"),
            "quarantined");
  EXPECT_EQ(Call(op, "POST rigs/bench-1/self-test", "{}").status, 409);
  Ok(Call(op, "POST rigs/bench-1/release", "{}"));
  WaitForBenches(2);
  Ok(Call(op, "POST rigs/bench-1/self-test", "{}"));
  WaitForBenches(2);
  const json::object outage =
      Ok(Call(op,
              "POST rigs/bench-2/outages",
              json::serialize(json::object{{"start", In(std::chrono::minutes(10))},
                                           {"end", In(std::chrono::minutes(70))},
                                           {"reason", "new brushes"}})),
         201);
  EXPECT_EQ(Ok(Call(ann, "GET rigs/bench-2/health")).at("outages").as_array().size(), 1u);
  const std::string path = "rigs/bench-2/outages/" + Id(outage);
  EXPECT_EQ(Call(op, "DELETE " + path).status, 204);
  EXPECT_EQ(Call(op, "DELETE " + path).status, 404);
  EXPECT_EQ(Call(op, "GET rigs/unicorn/health").status, 404);
}

TEST_F(ApiTest, AFilterThatIsNoneIsRefusedAndNotAnsweredByAnEmptyList) {
  const Person admin = Make("boss", Role::kAdmin);
  const auto refused = [&](const std::string& target) {
    return Ok(Call(admin, "GET " + target), 400);
  };
  const json::object verdict = refused("runs?verdict=xx");
  EXPECT_EQ(verdict.at("field"), "verdict");
  EXPECT_EQ(verdict.at("reason"), "word_unknown");
  EXPECT_EQ(verdict.at("parameters").at("words"),
            "calibrating, nominal, fault, unknown_fault, not_excited");
  const json::object verbs = refused("audit?verbs=quarantine,foo");
  EXPECT_EQ(verbs.at("field"), "verbs");
  EXPECT_EQ(verbs.at("reason"), "words_unknown");
  const json::object twice = refused("comparison.png?runs=a&runs=b");
  EXPECT_EQ(twice.at("field"), "runs");
  EXPECT_EQ(twice.at("reason"), "query_twice");
  Ok(Call(admin, "GET runs?verdict=unknown_fault&starred=true"));
  Ok(Call(admin, "GET audit?verbs=quarantine,release&q=bench"));
}

}  // namespace
}  // namespace faultlab::server
