// Runs every operation of the API's description on a running server: first correctly, with real
// ids; then by every role, with ids of other users and of nothing, and with every mistake that its
// parameters and its body's schema suggest. Each answer is checked against the description.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <chrono>
#include <cstdio>

#include "tests/support/await.h"
#include "tests/system/contract/bad_bodies.h"
#include "tests/system/contract/contract_world.h"

namespace faultlab::tests {
namespace {

namespace json = boost::json;
using std::chrono::minutes;
using Values = std::map<std::string, std::string>;

std::string Id(const json::object& object, const char* name = "id") {
  if (!object.contains(name)) return "1";
  const json::value& id = object.at(name);
  return id.is_string() ? std::string(id.as_string()) : std::to_string(id.as_int64());
}

std::string IfMatch(std::int64_t version) {
  return "If-Match: \"" + std::to_string(version) + "\"\r\n";
}

const std::string kCsv = "Content-Type: text/csv\r\n";
const std::string kGzip = "Content-Type: application/gzip\r\n";

std::string RecordingCsv() {
  std::string text = "t_s,uc_v,um_v\n";
  for (int i = 0; i < 700; ++i) {
    const double uc_v = (i * 7919 / 13) % 2 == 0 ? 2.0 : 3.0;
    text += std::to_string(i * 0.01) + "," + std::to_string(uc_v) + "," +
            std::to_string(2.4 * uc_v) + "\n";
  }
  return text;
}

/// The ids of the objects that exist when the mistakes begin, by pattern.
class Contract {
 public:
  void Experiments();
  void People();
  void Rigs();
  void Platforms();
  void Sessions();
  void JobsAndFaultSets();
  void Trials();
  void Mistakes();
  void Report();

 private:
  void Remember(const std::string& pattern, Values ids, const std::string& who) {
    known_[pattern] = {std::move(ids), who};
  }
  void Mistake(const std::string& method,
               const std::string& pattern,
               const json::object& operation);
  void WrongIds(const std::string& method, const std::string& pattern);
  void WrongQueries(const std::string& pattern, const json::object& operation);
  void WrongBodies(const std::string& method,
                   const std::string& pattern,
                   const json::object& operation);

  struct Known {
    Values ids;
    std::string who = "admin";
  };
  const Known& KnownOf(const std::string& pattern) {
    const auto found = known_.find(pattern);
    return found == known_.end() ? nobody_ : found->second;
  }

  ContractWorld world_;
  std::map<std::string, Known> known_;
  const Known nobody_{};
};

void Contract::Experiments() {
  for (const char* path : {"/healthz", "/readyz", "/metrics"}) {
    EXPECT_EQ(world_.Call("guest", "GET", path, path).status, 200);
  }
  for (const char* list : {"openapi.json", "auth/me", "rigs", "runs", "recordings"}) {
    world_.Expect(200, "ann", "GET", list);
  }
  const json::object benches = world_.Expect(200, "guest", "GET", "benches");
  const Values bench{{"bench", Id(benches.at("items").at(0).as_object())}};
  const HttpAnswer list = world_.Call("guest", "GET", "/api/v1/benches", "/api/v1/benches");
  world_.Expect(304,
                "guest",
                "GET",
                "benches",
                {},
                {},
                "If-None-Match: " + std::string(list.Header("ETag")) + "\r\n");
  world_.Expect(200, "guest", "GET", "benches/{bench}/model", bench);
  Remember("/api/v1/benches/{bench}/model", bench, "guest");
  const std::map<std::string, std::string> demonstrations = {
      {"benches/{bench}/demonstration", "?changes=R9:33000,R12:5600"},
      {"benches/{bench}/demonstration/estimates",
       "?changes=R1:10&method=sia&window=100&integral=5&rule=paper&noise_percent=1&parameter=2"},
      {"benches/{bench}/demonstration/detection", "?changes=R1:10&false_alarms_per_day=100"}};
  for (const auto& [pattern, query] : demonstrations) {
    world_.Expect(200, "guest", "GET", pattern, bench);
    const std::string described = "/api/v1/" + pattern;
    const std::string target = ContractWorld::Fill(described, bench);
    EXPECT_EQ(world_.Call("guest", "GET", described, target + query).status, 200);
    EXPECT_EQ(world_.Call("guest", "GET", described, target + "?changes=R1").status, 400);
    Remember(described, bench, "guest");
  }
  world_.Expect(200, "guest", "GET", "benches/{bench}", bench);
  Remember("/api/v1/benches/{bench}", bench, "guest");
  const HttpAnswer file = world_.Call("guest",
                                      "GET",
                                      "/api/v1/benches/{bench}/file",
                                      "/api/v1/benches/" + bench.at("bench") + "/file");
  EXPECT_EQ(file.status, 200);
  Remember("/api/v1/benches/{bench}/file", bench, "guest");
  const json::object run = world_.Expect(
      201,
      "ann",
      "POST",
      "runs",
      {},
      R"({"duration_s":8,"name":"contract","control":{},"faults":[{"component":"R1","value":100,"at_s":6}]})");
  const Values id{{"id", Id(run)}, {"figure", "swa"}};
  world_.Expect(201, "ann", "POST", "runs/{id}/stream-token", id);
  world_.WaitForRun(Id(run));
  for (const char* part : {"",
                           "/events",
                           "/frames",
                           "/samples",
                           "/estimates?estimator=swa_100",
                           "/diagnosis",
                           "/control?without=include",
                           "/export.csv",
                           "/export.csv?content=estimates",
                           "/report.pdf?language=sr",
                           "/export.mat",
                           "/export.lcm",
                           "/export.json",
                           "/export.ipynb"}) {
    const std::string target = "runs/{id}" + std::string(part);
    const std::string pattern = target.substr(0, target.find('?'));
    EXPECT_EQ(
        world_
            .Call("ann", "GET", "/api/v1/" + pattern, ContractWorld::Fill("/api/v1/" + target, id))
            .status,
        200)
        << target;
    Remember("/api/v1/" + pattern, id, "ann");
  }
  EXPECT_EQ(world_
                .Call("ann",
                      "GET",
                      "/api/v1/comparison.png",
                      "/api/v1/comparison.png?align=start&runs=" + Id(run) + "," + Id(run))
                .status,
            200);
  EXPECT_EQ(
      world_.Call("bob", "GET", "/api/v1/comparison.png", "/api/v1/comparison.png?runs=" + Id(run))
          .status,
      404);
  EXPECT_EQ(
      world_.Call("ann", "GET", "/api/v1/comparison.png", "/api/v1/comparison.png?runs=a,b,c,d,e")
          .status,
      400);
  for (const char* figure :
       {"runs/{id}/plots/{figure}.png", "runs/{id}/figures/{figure}", "runs/{id}/study"}) {
    world_.Expect(200, "ann", "GET", figure, id);
    Remember("/api/v1/" + std::string(figure), id, "ann");
  }
  const json::object described = world_.Expect(
      200, "ann", "PATCH", "runs/{id}", id, R"({"name":"A b 50%","note":"warm","starred":true})");
  EXPECT_EQ(described.at("note"), "warm");
  world_.Expect(404, "bob", "PATCH", "runs/{id}", id, R"({"starred":true})");
  world_.Expect(400, "ann", "PATCH", "runs/{id}", id, R"({"owner":"bob"})");
  const auto found = [this](const std::string& query) {
    const HttpAnswer answer = world_.Call("ann", "GET", "/api/v1/runs", "/api/v1/runs?" + query);
    EXPECT_EQ(answer.status, 200) << query;
    return json::parse(answer.body).at("items").as_array().size();
  };
  EXPECT_EQ(found("q=a%20B%2050%25"), 1u);
  EXPECT_EQ(found("q=50_"), 0u) << "no pattern of SQL";
  EXPECT_EQ(found("q=WARM&starred=true"), 1u);
  EXPECT_EQ(found("starred=true&rig=no-such"), 0u);
  EXPECT_EQ(found("q=warm&verdict=not_excited"), 0u);
  EXPECT_EQ(world_.Call("ann", "GET", "/api/v1/runs", "/api/v1/runs?starred=1").status, 400);
  const json::object unstarred =
      world_.Expect(200, "ann", "PATCH", "runs/{id}", id, R"({"starred":false})");
  EXPECT_EQ(unstarred.at("name"), "A b 50%");
  EXPECT_EQ(found("starred=true"), 0u);
  world_.Expect(409, "ann", "POST", "runs/{id}/stop", id);
  world_.Expect(409, "ann", "POST", "runs/{id}/calibration", id);
  const json::object long_run =
      world_.Expect(201, "ann", "POST", "runs", {}, R"({"rig":"sim-1","duration_s":600})");
  world_.Expect(200, "ann", "GET", "runs/{id}/camera", {{"id", Id(long_run)}});
  world_.Expect(409, "ann", "DELETE", "runs/{id}", {{"id", Id(long_run)}});
  world_.Expect(202, "ann", "POST", "runs/{id}/calibration", {{"id", Id(long_run)}}, "{}");
  world_.Expect(404, "bob", "POST", "runs/{id}/calibration", {{"id", Id(long_run)}}, "{}");
  world_.Expect(202, "ann", "POST", "runs/{id}/stop", {{"id", Id(long_run)}}, "{}");
  world_.WaitForRun(Id(long_run));
  world_.WaitForPicture(Id(long_run));
  const Values picture{{"id", Id(long_run)}, {"index", "1"}};
  world_.Expect(404, "ann", "GET", "runs/{id}/camera", picture);
  world_.Expect(200, "ann", "GET", "runs/{id}/pictures", picture);
  world_.Expect(200, "ann", "GET", "runs/{id}/pictures/{index}", picture);
  for (const char* part : {"camera", "pictures", "pictures/{index}"}) {
    Remember(
        "/api/v1/runs/{id}/" + std::string(part), {{"id", id.at("id")}, {"index", "1"}}, "ann");
  }
  world_.Expect(404, "bob", "GET", "runs/{id}", id);
  world_.Expect(204, "ann", "DELETE", "runs/{id}", {{"id", Id(long_run)}});
  Remember("/api/v1/runs/{id}/stop", id, "ann");
  Remember("/api/v1/runs/{id}/calibration", id, "ann");
  Remember("/api/v1/runs/{id}/stream-token", id, "ann");
  Remember("/api/v1/recordings", {}, "ann");
  const json::object upload =
      world_.Expect(201, "ann", "POST", "recordings", {}, RecordingCsv(), kCsv);
  // The mistakes delete the upload; the run remains for its other operations.
  Remember("/api/v1/runs/{id}", {{"id", Id(upload)}}, "ann");
}

void Contract::People() {
  world_.Expect(200,
                "guest",
                "POST",
                "auth/login",
                {},
                R"({"login":"bob","password":"correct horse battery"})");
  const json::object user = world_.Expect(
      201, "admin", "POST", "users", {}, R"({"login":"new.one","name":"Новая Студентка"})");
  const Values id{{"id", Id(user)}};
  const json::object link = world_.Expect(201, "admin", "POST", "users/{id}/reset-link", id, "{}");
  const std::string path = Id(link, "link");
  const json::object reset{{"token", path.substr(path.find('=') + 1)},
                           {"password", "another long password"}};
  world_.Expect(200,
                "guest",
                "POST",
                "auth/reset/owner",
                {},
                json::serialize(json::object{{"token", reset.at("token")}}));
  world_.Expect(204, "guest", "POST", "auth/reset", {}, json::serialize(reset));
  world_.Expect(200,
                "admin",
                "PATCH",
                "users/{id}",
                id,
                R"({"name":"N"})",
                IfMatch(user.at("version").as_int64()));
  for (const char* list : {"users", "audit", "courses", "api-keys"}) {
    world_.Expect(200, "admin", "GET", list);
  }
  Remember("/api/v1/users/{id}", id, "admin");
  Remember("/api/v1/users/{id}/reset-link", id, "admin");

  const json::object course =
      world_.Expect(201, "teacher", "POST", "courses", {}, R"({"name":"Regelungstechnik Ω"})");
  const Values course_id{{"id", Id(course)}};
  world_.Expect(200,
                "teacher",
                "POST",
                "courses/{id}/members",
                course_id,
                "login,name\nann,Ann\nbob,Bob\ncem,Cem\n",
                kCsv);
  const json::object members =
      world_.Expect(200, "teacher", "GET", "courses/{id}/members", course_id);
  for (const json::value& member : members.at("items").as_array()) {
    if (member.at("login") != "cem") continue;
    const Values out{{"id", course_id.at("id")}, {"user", Id(member.as_object())}};
    world_.Expect(204, "teacher", "DELETE", "courses/{id}/members/{user}", out);
    Remember("/api/v1/courses/{id}/members/{user}", out, "teacher");
  }
  world_.Expect(201, "teacher", "POST", "courses/{id}/links", course_id, "{}");
  world_.Expect(202, "teacher", "POST", "courses/{id}/mails", course_id, "{}");
  world_.Expect(200, "teacher", "GET", "courses/{id}/mails", course_id);
  // Nor does a platform lead here.
  world_.Expect(200, "teacher", "GET", "courses/{id}/rosters", course_id);
  world_.Expect(404, "teacher", "POST", "courses/{id}/rosters", course_id, "{}");
  world_.Expect(200, "teacher", "GET", "courses/{id}/invitations", course_id);
  world_.Expect(200, "ann", "GET", "invitations");
  const Values asked_by{{"course", course_id.at("id")}};
  world_.Expect(204, "ann", "POST", "invitations/{course}/accept", asked_by, "{}");
  world_.Expect(204, "bob", "POST", "invitations/{course}/decline", asked_by, "{}");
  world_.Expect(
      204, "teacher", "PUT", "courses/{id}/end", course_id, R"({"ends":"2027-02-28T00:00:00Z"})");
  for (const char* part : {"/members", "/invitations", "/end"}) {
    Remember("/api/v1/courses/{id}" + std::string(part), course_id, "teacher");
  }
  const json::object wanted{
      {"name", "k"}, {"scopes", json::array{"runs:read"}}, {"expires_at", world_.In(minutes(60))}};
  const json::object key =
      world_.Expect(201, "bob", "POST", "api-keys", {}, json::serialize(wanted));
  world_.Expect(204, "bob", "DELETE", "api-keys/{id}", {{"id", Id(key)}});
  world_.Expect(204,
                "bob",
                "POST",
                "auth/password",
                {},
                R"({"old":"correct horse battery","new":"correct horse battery"})");
  // No provider listens at this address; oidc.test.js signs in at real ones.
  const Values provider{{"id", "uni"}};
  world_.Expect(200, "guest", "GET", "auth/providers");
  world_.Expect(200, "ann", "GET", "usage");
  world_.Expect(200, "ann", "GET", "auth/identities");
  world_.Expect(303, "guest", "GET", "auth/oidc/{id}/start", provider);
  world_.Expect(303, "guest", "GET", "auth/oidc/{id}/callback", provider);
  world_.Expect(503, "ann", "POST", "auth/oidc/{id}/link", provider, "{}");
  world_.Expect(404, "ann", "DELETE", "auth/identities/{id}", provider);
  for (const char* one : {"oidc/{id}/start", "oidc/{id}/callback", "oidc/{id}/link"}) {
    Remember("/api/v1/auth/" + std::string(one), provider, "ann");
  }
  Remember("/api/v1/auth/identities/{id}", provider, "ann");
}

/// No platform listens at these addresses; lti.test.js launches from one.
void Contract::Platforms() {
  const auto platform = [](const char* client) {
    return R"({"label":"Moodle","issuer":"https://127.0.0.1:1","client_id":")" +
           std::string(client) +
           R"(","auth_url":"https://127.0.0.1:1/auth","token_url":"https://127.0.0.1:1/token",)"
           R"("keys_url":"https://127.0.0.1:1/keys"})";
  };
  const Values made{
      {"id", Id(world_.Expect(201, "admin", "POST", "lti/platforms", {}, platform("a")))}};
  const Values other{
      {"id", Id(world_.Expect(201, "admin", "POST", "lti/platforms", {}, platform("b")))}};
  world_.Expect(409, "admin", "POST", "lti/platforms", {}, platform("a"));
  world_.Expect(403, "teacher", "POST", "lti/platforms", {}, platform("c"));
  world_.Expect(200, "admin", "GET", "lti/platforms");
  world_.Expect(200, "admin", "POST", "lti/platforms/{id}/test", made, "{}");
  world_.Expect(200, "admin", "GET", "lti/platforms/{id}/grades", made);
  world_.Expect(200, "admin", "PUT", "lti/platforms/{id}", made, platform("d"));
  world_.Expect(409, "admin", "PUT", "lti/platforms/{id}", made, platform("b"));
  world_.Expect(200, "admin", "POST", "lti/invitations", {}, "{}");
  world_.Expect(204, "admin", "DELETE", "lti/platforms/{id}", other);
  world_.Expect(200, "guest", "GET", "lti/keys");
  for (const char* one : {"", "/test", "/grades"}) {
    Remember("/api/v1/lti/platforms/{id}" + std::string(one), made, "admin");
  }
}

void Contract::Rigs() {
  world_.WaitForBenches();
  const json::object hook =
      world_.Expect(201,
                    "admin",
                    "POST",
                    "webhooks",
                    {},
                    R"({"url":"https://127.0.0.1:1/hook","kinds":["rig_quarantined"]})");
  Platforms();
  world_.Expect(201,
                "robot",
                "POST",
                "webhooks",
                {},
                R"({"url":"https://hooks.example/x","kinds":["job_ended"]})");
  world_.Expect(200, "admin", "GET", "webhooks");
  world_.Expect(200, "admin", "POST", "webhooks/{id}/test", {{"id", Id(hook)}}, "{}");
  Remember("/api/v1/webhooks/{id}/test", {{"id", Id(hook)}}, "admin");
  const json::object other =
      world_.Expect(201,
                    "admin",
                    "POST",
                    "webhooks",
                    {},
                    R"({"url":"https://127.0.0.1:1/other","kinds":["your_turn"]})");
  world_.Expect(204, "admin", "DELETE", "webhooks/{id}", {{"id", Id(other)}});
  json::object policy = world_.Expect(200, "guest", "GET", "policy");
  const std::int64_t version = policy.at("version").as_int64();
  policy.erase("version");
  policy["live_bookings_max"] = 5;
  const std::string wanted = json::serialize(policy);
  world_.Expect(403, "operator", "PUT", "policy", {}, wanted, IfMatch(version));
  world_.Expect(200, "admin", "PUT", "policy", {}, wanted, IfMatch(version));
  world_.Expect(409, "admin", "PUT", "policy", {}, wanted, IfMatch(version));
  Remember("/api/v1/policy", {}, "admin");
  world_.Expect(200, "operator", "GET", "reports/use");
  EXPECT_EQ(
      world_.Call("admin", "GET", "/api/v1/reports/use.csv", "/api/v1/reports/use.csv").status,
      200);
  world_.Expect(200, "ann", "GET", "rig-classes");
  world_.Expect(
      200, "ann", "GET", "rig-classes/{rig_class}/availability", {{"rig_class", "bench"}});
  const Values of_benches{{"rig_class", "bench"}};
  policy = world_.Expect(200, "ann", "GET", "rig-classes/{rig_class}/policy", of_benches);
  policy.erase("version");
  world_.Expect(200,
                "admin",
                "PUT",
                "rig-classes/{rig_class}/policy",
                of_benches,
                json::serialize(policy),
                IfMatch(0));
  world_.Expect(204, "admin", "DELETE", "rig-classes/{rig_class}/policy", of_benches);
  const json::object late{{"title", "Ω"},
                          {"start", world_.In(minutes(60 * 24 * 300))},
                          {"end", world_.In(minutes(60 * 24 * 300 + 60))},
                          {"repeat", "FREQ=DAILY;COUNT=2"}};
  const json::object open = world_.Expect(
      201, "admin", "POST", "rig-classes/{rig_class}/hours", of_benches, json::serialize(late));
  world_.Expect(200, "ann", "GET", "rig-classes/{rig_class}/hours", of_benches);
  const Values these{{"rig_class", "bench"}, {"id", Id(open)}};
  world_.Expect(204, "admin", "DELETE", "rig-classes/{rig_class}/hours/{id}", these);
  for (const char* part : {"policy", "hours", "availability"}) {
    Remember("/api/v1/rig-classes/{rig_class}/" + std::string(part), of_benches, "admin");
  }
  Remember("/api/v1/rig-classes/{rig_class}/hours/{id}", these, "admin");
  const Values rig{{"id", "bench-1"}};
  world_.Expect(200, "ann", "GET", "rigs/{id}/health", rig);
  world_.Expect(200, "ann", "GET", "rigs/{id}/calibrations", rig);
  Remember("/api/v1/rigs/{id}/calibrations", rig, "ann");
  world_.Expect(200, "operator", "POST", "rigs/{id}/quarantine", rig, R"({"reason":"smells"})");
  const json::object alarm = world_.WaitForAlarm();
  const Values alarm_id{{"id", Id(alarm)}};
  world_.Expect(200, "operator", "POST", "alarms/{id}/acknowledge", alarm_id, "{}");
  Remember("/api/v1/alarms/{id}/acknowledge", alarm_id, "operator");
  world_.Expect(200, "operator", "GET", "queue");
  world_.Expect(200, "operator", "POST", "rigs/{id}/release", rig, "{}");
  world_.WaitForBenches();
  world_.Expect(200, "operator", "GET", "rigs/{id}/history", rig);
  Remember("/api/v1/rigs/{id}/history", rig, "operator");
  const Values relay{{"id", "bench-1"}, {"line", "17"}};
  world_.Expect(404, "operator", "POST", "rigs/{id}/relays/{line}/replaced", relay, "{}");
  Remember("/api/v1/rigs/{id}/relays/{line}/replaced", relay, "operator");
  const std::string preview = "/api/v1/rigs/{id}/outages/preview";
  const HttpAnswer effect =
      world_.Call("operator",
                  "GET",
                  preview,
                  "/api/v1/rigs/bench-1/outages/preview?start=" + world_.In(minutes(60)) +
                      "&end=" + world_.In(minutes(90)));
  EXPECT_EQ(effect.status, 200) << effect.body;
  Remember(preview, rig, "operator");
  world_.Expect(200, "operator", "POST", "rigs/{id}/self-test", rig, "{}");
  world_.WaitForBenches();
  world_.Expect(409, "operator", "POST", "rigs/{id}/adopt", rig, "{}");
  world_.Expect(200, "operator", "POST", "rigs/{id}/commission", rig, R"({"reason":"new motor"})");
  world_.WaitForBenches();
  const json::object when{{"start", world_.In(minutes(600))},
                          {"end", world_.In(minutes(660))},
                          {"reason", "new brushes"}};
  const json::object outage =
      world_.Expect(201, "operator", "POST", "rigs/{id}/outages", rig, json::serialize(when));
  world_.Expect(204,
                "operator",
                "DELETE",
                "rigs/{id}/outages/{outage}",
                {{"id", "bench-1"}, {"outage", Id(outage)}});
  for (const char* part : {"health", "outages"}) {
    Remember("/api/v1/rigs/{id}/" + std::string(part), rig, "operator");
  }
}

void Contract::Sessions() {
  for (const char* list : {"tickets", "bookings", "sessions", "events"}) {
    world_.Expect(200, "ann", "GET", list);
  }
  const HttpAnswer calendar =
      world_.Call("ann", "GET", "/api/v1/calendar.ics", "/api/v1/calendar.ics");
  EXPECT_EQ(calendar.status, 200);
  const json::object link = world_.Expect(201, "ann", "POST", "calendar-link", {}, "{}");
  world_.Expect(200, "ann", "GET", "calendar-link");
  const std::string address = Id(link, "link");
  const std::string by_link = "/api/v1/calendar/{token}.ics";
  EXPECT_EQ(world_.Call("guest", "GET", by_link, address).body.substr(0, 15), "BEGIN:VCALENDAR");
  world_.Expect(201, "ann", "POST", "calendar-link", {}, "{}");
  EXPECT_EQ(world_.Call("guest", "GET", by_link, address).status, 404) << "the one before ended";
  world_.Expect(204, "ann", "DELETE", "calendar-link");
  world_.Expect(201, "ann", "POST", "events/stream-token", {}, "{}");
  const json::object asked =
      world_.Expect(201, "ann", "POST", "tickets", {}, R"({"rig_class":"bench"})");
  const std::string ticket = Id(asked.at("ticket").as_object());
  world_.Expect(404, "bob", "POST", "tickets/{id}/accept", {{"id", ticket}}, "{}");
  const json::object session =
      world_.Expect(200, "ann", "POST", "tickets/{id}/accept", {{"id", ticket}}, "{}");
  const Values id{{"id", Id(session)}};
  world_.Expect(200, "ann", "POST", "sessions/{id}/still-there", id, "{}");
  world_.Expect(409, "ann", "POST", "sessions/{id}/extend", id, "{}");
  world_.Expect(200, "ann", "POST", "sessions/{id}/handover", id, R"({"to":"bob"})");
  world_.Expect(200, "bob", "POST", "sessions/{id}/handover/accept", id, "{}");
  world_.Expect(200, "bob", "POST", "sessions/{id}/handover", id, R"({"to":"ann"})");
  world_.Expect(200, "ann", "POST", "sessions/{id}/handover/accept", id, "{}");
  world_.Expect(200, "teacher", "POST", "sessions/{id}/take-over", id, R"({"reason":"it smokes"})");
  world_.Expect(200, "admin", "GET", "sessions");
  world_.Expect(204, "teacher", "POST", "sessions/{id}/end", id, "{}");
  world_.WaitForBenches();
  const json::object again =
      world_.Expect(201, "bob", "POST", "tickets", {}, R"({"rig_class":"bench"})");
  world_.Expect(
      204, "bob", "POST", "tickets/{id}/leave", {{"id", Id(again.at("ticket").as_object())}}, "{}");
  const json::object when{
      {"rig_class", "bench"}, {"start", world_.In(minutes(60))}, {"end", world_.In(minutes(90))}};
  const json::object booking =
      world_.Expect(201, "ann", "POST", "bookings", {}, json::serialize(when));
  const Values booked{{"id", Id(booking)}};
  world_.Expect(409, "ann", "POST", "bookings/{id}/claim", booked, "{}");
  world_.Expect(409, "ann", "DELETE", "bookings/{id}", booked, {}, IfMatch(7));
  world_.Expect(204, "ann", "DELETE", "bookings/{id}", booked, {}, IfMatch(1));
  const json::object later{
      {"rig_class", "bench"}, {"start", world_.In(minutes(120))}, {"end", world_.In(minutes(150))}};
  const json::object kept =
      world_.Expect(201, "ann", "POST", "bookings", {}, json::serialize(later));
  const json::object weekly{{"rig_class", "bench"},
                            {"start", world_.In(minutes(180))},
                            {"end", world_.In(minutes(210))},
                            {"repeat", "FREQ=WEEKLY;COUNT=2"}};
  world_.Expect(201, "bob", "POST", "bookings/series", {}, json::serialize(weekly));
  Remember("/api/v1/bookings/{id}", {{"id", Id(kept)}}, "ann");
  Remember("/api/v1/bookings/{id}/claim", {{"id", Id(kept)}}, "ann");
  // A session that stays active while the mistakes are made.
  const json::object live =
      world_.Expect(201, "ann", "POST", "tickets", {}, R"({"rig_class":"bench"})");
  const json::object works = world_.Expect(
      200, "ann", "POST", "tickets/{id}/accept", {{"id", Id(live.at("ticket").as_object())}}, "{}");
  for (const char* part : {"extend", "still-there", "handover"}) {
    Remember("/api/v1/sessions/{id}/" + std::string(part), {{"id", Id(works)}}, "ann");
  }
}

void Contract::JobsAndFaultSets() {
  const json::object batch = world_.Expect(
      202, "robot", "POST", "jobs", {}, R"({"runs":[{"duration_s":2},{"duration_s":2}]})");
  const Values job{{"id", Id(batch.at("items").at(0).as_object())}};
  world_.Expect(200, "robot", "GET", "jobs/{id}", job);
  const auto is_finished = [&] {
    return world_.Expect(200, "robot", "GET", "jobs/{id}", job).at("state") == "finished";
  };
  ASSERT_TRUE(tests::Await(is_finished));
  const Values sweep{{"id", std::string(batch.at("batch").as_string())}};
  for (const std::string file : {"sweep.png", "sweep", "sweep.csv", "curves.png", "jobs.jsonl"}) {
    world_.Expect(200, "robot", "GET", "jobs/batches/{id}/" + file, sweep);
    Remember("/api/v1/jobs/batches/{id}/" + file, sweep, "ann");
  }
  world_.Expect(200, "robot", "GET", "jobs/batches/{id}", sweep);
  world_.Expect(404, "bob", "GET", "jobs/batches/{id}", sweep);
  Remember("/api/v1/jobs/batches/{id}", sweep, "ann");
  world_.Expect(200, "ann", "GET", "jobs");
  world_.Expect(404, "bob", "GET", "jobs/{id}", job);
  Remember("/api/v1/jobs/{id}", job, "ann");
  // More jobs than the two workers can have begun, so that the last one still waits.
  const std::string many =
      R"({"runs":[{"duration_s":600},{"duration_s":600},{"duration_s":600},{"duration_s":2}]})";
  const json::object queued = world_.Expect(202, "ann", "POST", "jobs", {}, many);
  world_.Expect(
      204, "ann", "DELETE", "jobs/{id}", {{"id", Id(queued.at("items").at(3).as_object())}});
  const Values queue{{"id", std::string(queued.at("batch").as_string())}};
  world_.Expect(204, "ann", "DELETE", "jobs/batches/{id}", queue);
  world_.Expect(409, "ann", "DELETE", "jobs/batches/{id}", queue);
  const std::string set = R"({"name":"s","faults":[{"component":"R9","value":27000,"at_s":1}]})";
  const json::object made = world_.Expect(201, "teacher", "POST", "fault-sets", {}, set);
  const Values id{{"id", Id(made)}};
  world_.Expect(200, "teacher", "GET", "fault-sets");
  world_.Expect(200, "teacher", "PUT", "fault-sets/{id}", id, set, IfMatch(1));
  world_.Expect(409, "teacher", "DELETE", "fault-sets/{id}", id, {}, IfMatch(1));
  world_.Expect(204, "teacher", "DELETE", "fault-sets/{id}", id, {}, IfMatch(2));
  const json::object kept = world_.Expect(201, "teacher", "POST", "fault-sets", {}, set);
  const Values kept_id{{"id", Id(kept)}};
  for (const char* part : {"", "/isolability", "/isolability.png"}) {
    const std::string pattern = "fault-sets/{id}" + std::string(part);
    if (*part != '\0') world_.Expect(200, "teacher", "GET", pattern, kept_id);
    Remember("/api/v1/" + pattern, kept_id, "teacher");
  }
}

/// A teacher tries an assignment before the students do.
void Contract::Trials() {
  const json::object course =
      world_.Expect(201, "teacher", "POST", "courses", {}, R"({"name":"Trials"})");
  const json::object set = world_.Expect(
      201,
      "teacher",
      "POST",
      "fault-sets",
      {},
      R"({"name":"pool","pool":{"items":[{"component":"R9","low":15000,"high":33000,"onset_from_s":8}]}})");
  const auto assignment = [&](const std::string& more) {
    return R"({"name":"E","course":)" + Id(course) + R"(,"fault_set":)" + Id(set) +
           R"(,"due":"2099-01-01T00:00:00Z","reveal":"answer","plan":{"duration_s":12})" + more +
           "}";
  };
  const char* preview =
      R"({"bench":"paper","pool":{"items":[{"component":"R9","low":15000,"high":33000,"onset_from_s":8}]}})";
  world_.Expect(200, "teacher", "POST", "assignments/preview", {}, preview);
  world_.Expect(403, "bob", "POST", "assignments/preview", {}, preview);
  const Values made{{"id",
                     Id(world_.Expect(201,
                                      "teacher",
                                      "POST",
                                      "assignments",
                                      {},
                                      assignment(R"(,"rubric":{"hint_percent":10})")))}};
  const Values other{
      {"id", Id(world_.Expect(201, "teacher", "POST", "assignments", {}, assignment("")))}};
  world_.Expect(404, "bob", "GET", "assignments/{id}", made);
  const Values shared{
      {"id",
       Id(world_.Expect(
           201, "teacher", "POST", "assignments", {}, assignment(R"(,"group_max":2)")))}};
  world_.Expect(409, "teacher", "POST", "assignments/{id}/group", made, "{}");
  world_.Expect(200, "teacher", "POST", "assignments/{id}/group", shared, "{}");
  world_.Expect(409, "teacher", "POST", "assignments/{id}/group", shared, "{}");
  world_.Expect(204, "teacher", "DELETE", "assignments/{id}/group", shared);
  world_.Expect(
      400, "teacher", "POST", "assignments/{id}/group", shared, R"({"code":"no such code"})");
  Remember("/api/v1/assignments/{id}/group", shared, "teacher");
  world_.Expect(
      200, "teacher", "PATCH", "assignments/{id}", other, R"({"attempts":2})", IfMatch(1));
  world_.Expect(204, "teacher", "DELETE", "assignments/{id}", other);
  const json::object trial =
      world_.Expect(201, "teacher", "POST", "assignments/{id}/trials", made, "{}");
  world_.Expect(409, "teacher", "POST", "assignments/{id}/trials", made, "{}");
  const Values trial_id{{"id", Id(trial)}};
  world_.WaitForRun(std::string(trial.at("run").as_string()));
  const std::string answer = R"({"component":"R9","value":22000,"unit":"ohm","confidence":0.5})";
  world_.Expect(200, "teacher", "GET", "trials/{id}", trial_id);
  const Values hint{{"id", Id(trial)}, {"number", "1"}};
  world_.Expect(200, "teacher", "PUT", "trials/{id}/hints/{number}", hint);
  Remember("/api/v1/trials/{id}/hints/{number}", hint, "teacher");
  world_.Expect(200, "teacher", "POST", "trials/{id}/answer", trial_id, answer);
  world_.Expect(409, "teacher", "POST", "trials/{id}/answer", trial_id, answer);
  const Values extension{{"id", Id(world_.Expect(200, "teacher", "GET", "assignments/{id}", made))},
                         {"user", std::to_string(trial.at("account").as_int64())}};
  const std::string more = "assignments/{id}/extensions/{user}";
  world_.Expect(200, "teacher", "PUT", more, extension, R"({"due":"2099-02-01T00:00:00Z"})");
  world_.Expect(200, "teacher", "DELETE", more, extension);
  Remember("/api/v1/" + more, extension, "teacher");
  world_.Expect(
      200, "teacher", "PUT", "trials/{id}/points", trial_id, R"({"points":1,"reason":"x"})");
  world_.Expect(200, "teacher", "DELETE", "trials/{id}/points", trial_id);
  Remember("/api/v1/trials/{id}/points", trial_id, "teacher");
  for (const char* part : {"", "/trials", "/grades.csv", "/statistics"}) {
    const std::string pattern = "assignments/{id}" + std::string(part);
    world_.Expect(200, "teacher", "GET", pattern, made);
    Remember("/api/v1/" + pattern, made, "teacher");
  }
  Remember("/api/v1/trials/{id}", trial_id, "teacher");
  Remember("/api/v1/trials/{id}/answer", trial_id, "teacher");
}

void Contract::WrongIds(const std::string& method, const std::string& pattern) {
  const Known& known = KnownOf(pattern);
  for (const auto& [name, right] : known.ids) {
    if (pattern.find("{" + name + "}") == std::string::npos) continue;
    for (const std::string& wrong : {std::string("0"),
                                     std::string("-1"),
                                     std::string("99999999999999999999999"),
                                     std::string("nope"),
                                     std::string("..%2f..%2fetc%2fpasswd"),
                                     std::string("%27%20OR%201=1"),
                                     std::string("%F0%9F%92%A9"),
                                     std::string(300, 'x')}) {
      Values ids = known.ids;
      ids[name] = wrong;
      const HttpAnswer answer =
          world_.Call(known.who, method, pattern, ContractWorld::Fill(pattern, ids));
      EXPECT_GE(answer.status, 400) << method << " " << pattern << " " << wrong;
    }
  }
}

void Contract::WrongQueries(const std::string& pattern, const json::object& operation) {
  const Known& known = KnownOf(pattern);
  const std::string target = ContractWorld::Fill(pattern, known.ids);
  const auto ask = [&](const std::string& query) {
    return world_.Call(known.who, "GET", pattern, target + "?" + query).status;
  };
  (void)ask("no_such_parameter=1");
  const json::value* parameters = operation.if_contains("parameters");
  if (parameters == nullptr) return;
  for (const json::value& parameter : parameters->as_array()) {
    if (parameter.at("in") != "query") continue;
    const std::string name(parameter.at("name").as_string());
    for (const char* wrong :
         {"", "x", "-1", "1e9", "9999999999999999999999", "%00", "%ff", "1;DROP", "../.."}) {
      (void)ask(name + "=" + wrong);
    }
    if (name == "limit" || name == "since" || name == "from") {
      EXPECT_EQ(ask(name + "=x"), 400) << pattern << " " << name;
    }
    if (name == "limit") {
      EXPECT_EQ(ask("limit=1000000"), 400) << pattern;
    }
    if (name == "cursor") {
      EXPECT_EQ(ask("cursor=garbage"), 400) << pattern;
    }
  }
}

void Contract::WrongBodies(const std::string& method,
                           const std::string& pattern,
                           const json::object& operation) {
  const json::value* request = operation.if_contains("requestBody");
  if (request == nullptr) return;
  const Known& known = KnownOf(pattern);
  const std::string target = ContractWorld::Fill(pattern, known.ids);
  const json::object& content = request->at("content").as_object();
  const auto send = [&](const std::string& body, const std::string& headers) {
    return world_.Call(known.who, method, pattern, target, body, headers + IfMatch(99)).status;
  };
  if (content.contains("text/csv")) {
    for (const char* body : {"\x01\x02", "a,b\n1", "t_s,uc_v,um_v\n0,1\n", "login\n\n\n,,,"}) {
      EXPECT_GE(send(body, kCsv), 400) << pattern << " " << body;
      EXPECT_GE(send(body, kGzip), 400) << pattern << " " << body;
    }
    return;
  }
  if (content.contains("application/x-www-form-urlencoded")) {  // of a page of another site
    for (const char* body : {"", "x=1", "state=%00&id_token=%zz", "\x01\x02", "iss&iss"}) {
      EXPECT_GE(send(body, "Origin: https://elsewhere.example\r\n"), 400) << pattern << " " << body;
    }
    return;
  }
  const json::object& media = content.at("application/json").as_object();
  const json::value* example = media.if_contains("example");
  const json::object good =
      example != nullptr && example->is_object() ? example->as_object() : json::object{};
  EXPECT_FALSE(world_.description().CheckRequest(method, pattern, json::serialize(good)))
      << pattern << ": its example does not fit its schema";
  EXPECT_EQ(send("x=1", "Content-Type: application/x-www-form-urlencoded\r\n"), 415) << pattern;
  EXPECT_EQ(send(std::string(std::size_t{5} << 20, ' '), ""), 413) << pattern;
  for (const BadBody& bad : BadBodies(world_.description().document(), media.at("schema"), good)) {
    if (bad.text.empty()) continue;
    // The server must refuse what the schema refuses; what the schema cannot express, the server
    // may accept.
    const bool refused = world_.description().CheckRequest(method, pattern, bad.text).has_value();
    if (!refused) continue;
    EXPECT_GE(send(bad.text, ""), 400) << method << " " << pattern << ": " << bad.mistake << "\n"
                                       << bad.text.substr(0, 500);
  }
}

void Contract::Mistake(const std::string& method,
                       const std::string& pattern,
                       const json::object& operation) {
  const Known& known = KnownOf(pattern);
  // Without a matching If-Match and without a body, a request changes nothing.
  for (const char* who : {"guest", "bob", "ann", "robot", "reader", "teacher", "operator"}) {
    if (pattern.ends_with("/auth/logout") || method == "POST") break;
    (void)world_.Call(
        who, method, pattern, ContractWorld::Fill(pattern, known.ids), {}, IfMatch(99));
  }
  if (method == "POST" && !pattern.ends_with("/runs") && !pattern.ends_with("/auth/logout")) {
    for (const char* who : {"guest", "reader", "bob"}) {
      (void)world_.Call(who, method, pattern, ContractWorld::Fill(pattern, known.ids), "[]");
    }
  }
  WrongIds(method, pattern);
  if (method == "GET") WrongQueries(pattern, operation);
  if (!pattern.ends_with("/auth/logout")) WrongBodies(method, pattern, operation);
}

void Contract::Mistakes() {
  for (const auto& [path, operations] : world_.description().document().at("paths").as_object()) {
    for (const auto& [name, operation] : operations.as_object()) {
      std::string method(name);
      for (char& c : method) c = static_cast<char>(std::toupper(c));
      Mistake(method, std::string(path), operation.as_object());
    }
  }
  world_.Expect(204, "bob", "POST", "auth/logout", {}, "{}");
  EXPECT_EQ(Get(world_.port(), "/healthz").status, 200) << "and it lives on";
}

void Contract::Report() {
  int described = 0;
  int reached = 0;
  for (const auto& [path, operations] : world_.description().document().at("paths").as_object()) {
    for (const auto& [name, operation] : operations.as_object()) {
      const std::string key = std::string(name) + " " + std::string(path);
      const auto seen = world_.seen().find(key);
      ASSERT_NE(seen, world_.seen().end()) << key << " was never asked";
      std::string missing;
      bool succeeded = false;
      for (const auto& [status, response] : operation.at("responses").as_object()) {
        const int number = std::stoi(std::string(status));
        ++described;
        if (seen->second.contains(number)) {
          ++reached;
          succeeded = succeeded || number < 300;
        } else {
          missing += " " + std::to_string(number);
        }
      }
      // Signing in at a provider is tested by oidc.test.js, which has providers.
      const bool elsewhere =
          path.starts_with("/api/v1/auth/oidc/") || path == "/api/v1/auth/identities/{id}" ||
          path == "/api/v1/lti/login" || path == "/api/v1/lti/launch" ||
          path == "/api/v1/lti/window" || path.starts_with("/api/v1/lti/register/") ||
          key == "post /api/v1/courses/{id}/rosters";
      EXPECT_TRUE(succeeded || elsewhere || path == "/api/v1/bookings/{id}/claim" ||
                  path == "/api/v1/sessions/{id}/extend" ||  // a session extends itself
                  path == "/api/v1/rigs/{id}/clear-trip" || path == "/api/v1/rigs/{id}/adopt" ||
                  path == "/api/v1/rigs/{id}/relays/{line}/replaced")
          << key << " never did what it is for";
      if (!missing.empty()) std::printf("  not reached: %s%s\n", key.c_str(), missing.c_str());
    }
  }
  std::printf("%d calls; %d of %d described answers reached\n", world_.calls(), reached, described);
}

TEST(Contract, EveryOperationKeepsItsDescriptionInGoodAndInBadUse) {
  Contract contract;
  contract.Experiments();
  contract.People();
  contract.Rigs();
  contract.JobsAndFaultSets();
  contract.Trials();
  contract.Sessions();
  contract.Mistakes();
  contract.Report();
}

}  // namespace
}  // namespace faultlab::tests
