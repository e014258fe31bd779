// While a blind exercise is open, nobody gets the lab's diagnosis of its records.
#include <algorithm>
#include <charconv>
#include <sstream>

#include "core/signals/random.h"
#include "tests/core/fingerprint/disguise.h"
#include "tests/server/api/trial_world.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr double kPeriodS = 0.01;

const core::OwnNoise kOwn = {15e-3, 15e-3, 1e-3, 0.5};  // of benches/paper.toml

std::string CsvOf(const std::vector<core::Sample>& samples) {
  std::ostringstream out;
  out.precision(9);
  const bool um_alone = std::isnan(samples.front().ua_v);
  out << "t_s,uc_v,um_v" << (um_alone ? "" : ",ua_v,ia_a,n_rpm") << '\n';
  for (const core::Sample& each : samples) {
    out << each.t_s << ',' << each.uc_v << ',' << each.um_v;
    if (!um_alone) out << ',' << each.ua_v << ',' << each.ia_a << ',' << each.n_rpm;
    out << '\n';
  }
  return out.str();
}

class ExamRoomTest : public TrialTest {
 protected:
  tests::HttpAnswer Bring(const Person& who, const std::string& csv) {
    return Call(who, "POST recordings", csv, kCsv);
  }
  std::vector<core::Sample> SamplesOf(const std::string& run) {
    RecordingStore store(*database_);
    return store.LoadSamples(run).value();
  }
  json::object Run(const Person& who, const std::string& id) {
    return Ok(Call(who, "GET runs/" + id));
  }
  tests::HttpAnswer Diagnosis(const Person& who, const std::string& id) {
    return Call(who, "GET runs/" + id + "/diagnosis");
  }
};

TEST_F(ExamRoomTest, ACopyWaitsForTheReleaseAndTheTeacherIsToldWhoBroughtIt) {
  const Person bob = Make("bob", Role::kStudent);  // attends no course of it
  const std::int64_t assignment = Assign(kRa, R"(,"plan":{"duration_s":14})");
  const json::object begun = Play(assignment);
  const std::int64_t trial = begun.at("id").as_int64();
  const std::string run = Text(begun, "run");
  const tests::HttpAnswer csv = Call(ann_, "GET runs/" + run + "/export.csv");
  ASSERT_EQ(csv.status, 200);

  const json::object brought = Ok(Bring(bob, csv.body), 201);
  std::string copy(brought.at("id").as_string());
  EXPECT_EQ(brought.at("sealed"), true);
  EXPECT_EQ(brought.at("verdict"), "calibrating");
  EXPECT_NE(Text(brought, "reason").find("still open"), std::string::npos);
  EXPECT_EQ(Ok(Diagnosis(bob, copy)).at("verdict"), "calibrating");
  const auto refused = [&](const std::string& route, const std::string& body) {
    return ReasonOf(Call(bob, "POST " + route, body));
  };
  EXPECT_EQ(refused("runs", R"({"recording":")" + copy + "\"}"), "run_sealed");
  for (const char* job : {"diagnose", "methods"}) {
    const std::string body = job == std::string("diagnose")
                                 ? R"({"diagnose":{"recording":")" + copy + "\"}}"
                                 : R"({"methods":{"recording":")" + copy + "\"}}";
    EXPECT_EQ(refused("jobs", R"({"name":"d","runs":[)" + body + "]}"), "run_sealed") << job;
  }
  EXPECT_EQ(
      ReasonOf(Call(bob,
                    "POST recordings?calibration=" + copy,
                    CsvOf(SamplesOf(Play(Assign(kRa, kAtOnce)).at("run").as_string().c_str())),
                    kCsv)),
      "run_sealed");
  EXPECT_EQ(Call(bob, "DELETE runs/" + copy).status, 204) << "it is his own";
  copy = Ok(Bring(bob, csv.body), 201).at("id").as_string();
  EXPECT_EQ(Call(ann_, "GET runs/" + copy).status, 404) << "it is bob's";

  EXPECT_FALSE(Trial(ann_, trial).contains("copies"));
  const json::array copies = Trial(mila_, trial).at("copies").as_array();
  ASSERT_EQ(copies.size(), 1U) << "a line a person";
  EXPECT_EQ(copies[0].at("account"), AccountOf("bob"));
  EXPECT_EQ(copies[0].at("recording").as_string(), copy);
  const json::object log = Ok(Call(Admin(), "GET audit?limit=100"));
  EXPECT_TRUE(std::ranges::any_of(log.at("items").as_array(), [&](const json::value& line) {
    return line.at("verb") == "bring_sealed" && line.at("actor_login") == "bob";
  }));

  MakeDue(assignment);
  EXPECT_FALSE(Run(bob, copy).at("plan").as_object().contains("sealed"));
  const json::object opened = Ok(Diagnosis(bob, copy));
  EXPECT_EQ(opened.at("verdict"), "fault");
  EXPECT_EQ(opened.at("candidates").at(0).at("component"), "Ra");
  EXPECT_EQ(Ok(Bring(bob, csv.body), 201).at("sealed"), false) << "it is released";
  EXPECT_EQ(Call(bob, "DELETE runs/" + copy).status, 204);
}

TEST_F(ExamRoomTest, NoneOfTwentyDisguisesIsDiagnosed) {
  const std::string run(Play(Assign(kRa, R"(,"plan":{"duration_s":14})")).at("run").as_string());
  const std::vector<core::Sample> record = SamplesOf(run);
  core::Random random(1);
  for (int each = 0; each < 20; ++each) {
    core::Disguise disguise = core::DrawDisguise(record.size(), 1200, 1.0, random);
    // What the reader of files refuses is no way around: noise and gains within its limits.
    disguise.scale = std::clamp(disguise.scale, 0.8, 1.25);
    disguise.command_scale = std::clamp(disguise.command_scale, 0.8, 1.25);
    disguise.offset = 0.0;
    const auto copy = core::Dress(record, disguise, kOwn, kPeriodS, random);
    const json::object brought = Ok(Bring(ann_, CsvOf(copy)), 201);
    EXPECT_EQ(brought.at("sealed"), true) << each;
    EXPECT_EQ(brought.at("verdict"), "calibrating") << each;
  }
}

TEST_F(ExamRoomTest, ARunIsKnownWhileItGoesOnAndOnesOwnRunsAreDiagnosed) {
  PlayAtSpeed(4.0);
  const json::object begun = Ok(TryStart(ann_, Assign(kRa, R"(,"plan":{"duration_s":600})")), 201);
  const std::string run = Text(begun, "run");
  // It is looked at more than once.
  ASSERT_TRUE(tests::Await([&] { return SamplesOf(run).size() >= 50; }));
  (void)Bring(ann_, CsvOf(SamplesOf(run)));
  ASSERT_TRUE(tests::Await([&] { return SamplesOf(run).size() >= 400; }));
  const std::vector<core::Sample> begin = SamplesOf(run);
  EXPECT_EQ(Ok(Bring(ann_, CsvOf(begin)), 201).at("sealed"), true);

  const json::object own =
      Ok(Call(ann_, "POST runs", R"({"duration_s":14})"), 201);  // the same voltages
  application_->runs().Wait(Id(own));
  const json::object mine = Ok(Bring(ann_, CsvOf(SamplesOf(Id(own)))), 201);
  EXPECT_EQ(mine.at("sealed"), false);
  EXPECT_EQ(mine.at("verdict"), "nominal");
  EXPECT_EQ(Call(ann_, "POST runs/" + run + "/stop").status, 202);
  application_->runs().Wait(run);
}

TEST_F(ExamRoomTest, ATeacherMayLetUploadsOfStudentsWait) {
  const std::int64_t assignment =
      Assign(kRa, R"(,"plan":{"duration_s":14},"rubric":{"uploads_wait":true})");
  const std::string csv = "t_s,uc_v,um_v\n0.00,2,4\n0.01,3,6\n0.02,2,4\n";
  EXPECT_EQ(ReasonOf(Bring(ann_, csv)), "uploads_wait");
  EXPECT_NE(ReasonOf(Bring(mila_, csv)), "uploads_wait") << "she teaches it";
  EXPECT_NE(ReasonOf(Bring(Make("bob", Role::kStudent), csv)), "uploads_wait");
  MakeDue(assignment);
  EXPECT_NE(ReasonOf(Bring(ann_, csv)), "uploads_wait");
}

}  // namespace
}  // namespace faultlab::server
