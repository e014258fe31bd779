// Fault sets and jobs over HTTP, and the example clients.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "server/api/iso8601.h"
#include "tests/server/api/api_world.h"
#include "tests/support/await.h"
#include "tests/support/paths.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using tests::HttpAnswer;

TEST_F(ApiTest, FaultSetsAreSharedInACourseImmutableOnceUsedAndHiddenWhenTold) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const Person ann = Make("ann", Role::kStudent);
  const Person stranger = Make("stranger", Role::kStudent);
  const Course course = MakeCourse("teacher", "ann");
  json::object wanted{{"name", "Verstärker"},
                      {"course", course.id},
                      {"faults", json::parse(R"([{"component":"R9","value":27000,"at_s":1}])")}};
  const json::object made = Ok(Call(teacher, "POST fault-sets", json::serialize(wanted)), 201);
  const std::string id = Id(made);
  const auto listed = [&](const Person& who) { return Items(who, "fault-sets").size(); };
  EXPECT_EQ(listed(ann), 1u);
  EXPECT_EQ(listed(stranger), 0u);
  const std::string run = R"({"duration_s":2,"fault_set":)" + id + "}";
  EXPECT_EQ(Call(stranger, "POST runs", run).status, 400);
  const json::object started = Ok(Call(ann, "POST runs", run), 201);
  EXPECT_EQ(started.at("plan").at("faults").at(0).at("component"), "R9");

  wanted["visible"] = false;
  const json::object next =
      Ok(Call(teacher, "PUT fault-sets/" + id, json::serialize(wanted), IfMatch(1)));
  EXPECT_NE(next.at("id"), made.at("id")) << "the used one stays as it was";
  EXPECT_EQ(next.at("replaces"), made.at("id"));
  EXPECT_EQ(next.at("version"), 2);
  EXPECT_EQ(listed(ann), 0u) << "hidden";
  EXPECT_EQ(listed(teacher), 1u);
  const std::string next_path = "fault-sets/" + Id(next);
  EXPECT_EQ(Call(ann, "DELETE " + next_path, {}, IfMatch(2)).status, 403);
  EXPECT_EQ(Call(teacher, "DELETE " + next_path, {}, IfMatch(2)).status, 204);
  const json::object bad{{"name", "x"},
                         {"faults", json::parse(R"([{"component":"R99","value":1}])")}};
  EXPECT_EQ(Call(teacher, "POST fault-sets", json::serialize(bad)).status, 400);
}

TEST_F(ApiTest, ATeacherListsTheRunsOfTheStudentsOfACourse) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const Person ann = Make("ann", Role::kStudent);
  const Person stranger = Make("stranger", Role::kStudent);
  const Course course = MakeCourse("teacher", "ann");
  std::vector<std::string> of_ann;
  for (const Person& who : {ann, stranger, ann, teacher}) {
    const json::object run = Ok(Call(who, "POST runs", R"({"duration_s":1})"), 201);
    if (who.headers == ann.headers) of_ann.insert(of_ann.begin(), run.at("id").as_string().c_str());
  }
  const std::string query = "?course=" + std::to_string(course.id);
  std::vector<std::string> listed;
  std::string cursor;
  do {
    const json::object page = Ok(Call(teacher, "GET runs" + query + "&limit=1" + cursor));
    for (const json::value& run : page.at("items").as_array()) {
      listed.push_back(Id(run));
    }
    const json::value& next = page.at("next_cursor");
    cursor = next.is_null() ? "" : "&cursor=" + std::string(next.as_string());
  } while (!cursor.empty());
  EXPECT_EQ(listed, of_ann);
  EXPECT_EQ(Call(ann, "GET runs" + query).status, 400) << "attends, does not teach";
  EXPECT_EQ(Call(teacher, "GET runs?course=999").status, 400);
  EXPECT_EQ(Call(kNobody, "GET runs" + query).status, 400);
}

TEST_F(ApiTest, AFaultSetIsJudgedBeforeAnyRunByWhoeverMayReadIt) {
  const Person teacher = Make("teacher", Role::kInstructor);
  const Person stranger = Make("stranger", Role::kStudent);
  const json::object set = Ok(
      Call(
          teacher,
          "POST fault-sets",
          R"({"name":"Gain","faults":[{"component":"R9","value":27000,"at_s":1},{"component":"B","value":2e-6,"at_s":1}]})"),
      201);
  const std::string path = "fault-sets/" + Id(set) + "/isolability";
  const auto judge = [&](const std::string& query) {
    return Ok(Call(teacher, "GET " + path + query)).at("faults").as_array();
  };
  const json::array by_um = judge("");
  ASSERT_EQ(by_um.size(), 2u);
  EXPECT_TRUE(by_um[0].at("visible").as_bool());
  EXPECT_EQ(by_um[0].at("group"), (json::array{"R9", "R12"})) << "no sensor tells them apart";
  EXPECT_FALSE(by_um[1].at("visible").as_bool()) << "B x 1.1 by um alone";
  const auto distance = [](const json::array& faults) {
    return faults[0].at("kl_nominal").to_number<double>();
  };
  EXPECT_GT(distance(judge("?channels=all&window_samples=200")), distance(by_um));
  EXPECT_LT(distance(judge("?um_noise_v=0.3")), 0.1 * distance(by_um));
  EXPECT_LT(distance(judge("?excitation=prbs:low=2.4,high=2.6")), distance(by_um));

  EXPECT_EQ(Call(stranger, "GET " + path).status, 404);
  for (const char* wrong : {"channels=sound",
                            "window_samples=9",
                            "window_samples=501",
                            "um_noise_v=0",
                            "um_noise_v=x",
                            "profile=moon",
                            "rig=nobody",
                            "rig=sim-1",
                            "excitation=file:/etc/hostname",
                            "excitation=prbs:low=x"}) {
    const HttpAnswer refused = Call(teacher, "GET " + path + "?" + wrong);
    EXPECT_EQ(refused.status, 400) << wrong;
    const std::string field(json::parse(refused.body).at("field").as_string());
    EXPECT_EQ(std::string(wrong).substr(0, field.size()), field) << refused.body;
  }
  const HttpAnswer png = Call(teacher, "GET " + path + ".png?channels=all");
  EXPECT_EQ(png.status, 200);
  EXPECT_TRUE(png.body.starts_with("\x89PNG"));
}

TEST_F(ApiTest, WhoTeachesNoMoreHasNoHiddenFaultSetsMore) {
  const Person teacher = Make("teacher", Role::kInstructor);
  (void)Make("ann", Role::kStudent);
  const Course course = MakeCourse("teacher", "ann");
  const std::string hidden = json::serialize(
      json::object{{"name", "quiz"},
                   {"course", course.id},
                   {"visible", false},
                   {"faults", json::parse(R"([{"component":"R9","value":27000,"at_s":1}])")}});
  const json::object set = Ok(Call(teacher, "POST fault-sets", hidden), 201);
  const std::string path = "fault-sets/" + Id(set) + "/isolability";
  const auto status_for = [&](const Person& who) { return Call(who, "GET " + path).status; };
  EXPECT_EQ(status_for(teacher), 200);
  const Account account = accounts_->GetByLogin("teacher").value();
  ASSERT_TRUE(accounts_->Change(account.id, account.version, {}, Role::kStudent, {}).ok());
  const Person student = ByPassword("teacher");
  EXPECT_EQ(status_for(student), 404);
  const json::object list = Ok(Call(student, "GET fault-sets"));
  EXPECT_EQ(json::serialize(list).find("quiz"), std::string::npos);
}

TEST_F(ApiTest, ABatchThatIsRefusedUsesNoFaultSet) {
  const Person teacher = Make("teacher", Role::kInstructor);
  json::object wanted{{"name", "a"},
                      {"faults", json::parse(R"([{"component":"R9","value":27000,"at_s":1}])")}};
  json::object set = Ok(Call(teacher, "POST fault-sets", json::serialize(wanted)), 201);
  const auto change = [&] {
    const std::string request = "PUT fault-sets/" + Id(set);
    const std::string match = IfMatch(set.at("version").as_int64());
    const json::value before = set.at("id");
    set = Ok(Call(teacher, request, json::serialize(wanted), match));
    return set.at("id") != before;
  };
  const std::string run = R"({"duration_s":2,"fault_set":)" + Id(set) + "}";
  const std::string wrong = R"({"runs":[)" + run + R"(,{"duration_s":99999}]})";
  EXPECT_EQ(Call(teacher, "POST jobs", wrong).status, 400);
  EXPECT_FALSE(change()) << "nothing has used it";
  (void)Ok(Call(teacher, "POST jobs", R"({"runs":[)" + run + "]}"), 202);
  EXPECT_TRUE(change()) << "a used one stays as it was";
}

TEST_F(ApiTest, ABatchOfJobsRunsToItsResultsAndABadRunIsNamedBeforehand) {
  const Person ann = Make("ann", Role::kStudent);
  const std::string bad = R"({"runs":[{"duration_s":2},{"duration_s":99999}]})";
  const HttpAnswer refused = Call(ann, "POST jobs", bad);
  EXPECT_EQ(refused.status, 400);
  EXPECT_EQ(json::parse(refused.body).at("field"), "/runs/1/duration_s");
  const std::string good =
      R"({"name":"sweep","runs":[{"duration_s":2},{"duration_s":2,"seed":2},{"duration_s":2,"seed":3}]})";
  const json::object batch = Ok(Call(ann, "POST jobs", good, "Idempotency-Key: sweep-1\r\n"), 202);
  const std::string again = Call(ann, "POST jobs", good, "Idempotency-Key: sweep-1\r\n").body;
  EXPECT_EQ(json::parse(again).at("batch"), batch.at("batch"));
  const std::string list = "jobs?batch=" + Text(batch, "batch");
  json::array items;
  const auto done = [&] {
    items = Items(ann, list);
    return std::all_of(items.begin(), items.end(), [](const json::value& job) {
      return job.at("state") == "finished" || job.at("state") == "failed";
    });
  };
  ASSERT_TRUE(tests::Await(done));
  ASSERT_EQ(items.size(), 3u);
  for (const json::value& job : items) {
    EXPECT_EQ(job.at("state"), "finished") << json::serialize(job);
    const std::string run = Text(job, "run");
    EXPECT_EQ(Ok(Call(ann, "GET runs/" + run)).at("samples"), 200);
  }
  const std::string first = "jobs/" + Id(items[0]);
  EXPECT_EQ(Ok(Call(ann, "GET " + first)).at("progress"), 1.0);
  EXPECT_EQ(Call(ann, "DELETE " + first).status, 409);
  const Person bob = Make("bob", Role::kStudent);
  EXPECT_EQ(Call(bob, "GET " + first).status, 404);
}

TEST_F(ApiTest, JobsThatWaitCountForTheirOwnerUntilTheyEnd) {
  const Person ann = Make("ann", Role::kStudent);
  const auto bytes = [&] {
    return Ok(Call(ann, "GET usage")).at("job_bytes").to_number<std::int64_t>();
  };
  EXPECT_EQ(bytes(), 0);
  json::array runs;
  for (int seed = 0; seed < 50; ++seed) runs.push_back({{"duration_s", 100}, {"seed", seed}});
  const std::string body = json::serialize(json::object{{"name", "sweep"}, {"runs", runs}});
  const json::object batch = Ok(Call(ann, "POST jobs", body), 202);
  EXPECT_GT(bytes(), 0);
  const std::string list = "jobs?limit=100&batch=" + Text(batch, "batch");
  const json::object jobs = Ok(Call(ann, "GET " + list));
  for (const json::value& job : jobs.at("items").as_array()) {
    (void)Call(ann, "DELETE jobs/" + Id(job));
  }
  EXPECT_TRUE(tests::Await([&] { return bytes() == 0; })) << "running jobs finish first";
}

TEST_F(ApiTest, CoursesComeInPages) {
  const Person teacher = Make("teacher", Role::kInstructor);
  for (const char* name : {"a", "b", "c"}) {
    const std::string body = json::serialize(json::object{{"name", name}});
    (void)Ok(Call(teacher, "POST courses", body), 201);
  }
  std::string names;
  std::string target = "courses?limit=2";
  while (!target.empty()) {
    const json::object page = Ok(Call(teacher, "GET " + target));
    for (const json::value& course : page.at("items").as_array()) {
      names += course.at("name").as_string();
    }
    const json::value& cursor = page.at("next_cursor");
    target = cursor.is_null() ? "" : "courses?limit=2&cursor=" + std::string(cursor.as_string());
  }
  EXPECT_EQ(names, "abc");
  EXPECT_EQ(Call(teacher, "GET courses?cursor=x").status, 400);
}

TEST_F(ApiTest, TheExampleClientsSweepAndSaveTheirData) {
  const auto account = accounts_->Create("robot", "Robot", Role::kStudent, Now()).value();
  Principal who;
  who.user_id = account.id;
  const auto key =
      accounts_->CreateKey(who, "k", {"jobs", "runs:read"}, Now() + std::chrono::hours(1), Now());
  const std::string url = "http://" + application_->address();
  const std::string examples = tests::InSource("deploy/examples/");
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

}  // namespace
}  // namespace faultlab::server
