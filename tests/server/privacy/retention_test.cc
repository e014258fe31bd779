#include "server/privacy/retention.h"

#include <gmock/gmock.h>

#include <algorithm>

#include "server/auth/accounts.h"
#include "server/jobs/job_store.h"
#include "server/lab/members.h"
#include "server/storage/bench_store.h"
#include "server/storage/picture_store.h"
#include "server/storage/recording_store.h"
#include "server/storage/rig_calibrations.h"
#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using std::chrono::hours;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr WallTime kToday{std::chrono::milliseconds{1'800'000'000'000}};

WallTime DaysAgo(int days) {
  return kToday - hours(24) * days;
}

class RetentionTest : public testing::TestWithParam<Engine> {
 protected:
  RetentionTest() {
    EXPECT_TRUE(database_
                    ->Write(Durability::kPromise,
                            [](Transaction& tx) -> core::Status {
                              lab::members::Put(tx, {"s", "boot", "", {}});
                              return core::Done{};
                            })
                    .ok());
  }
  void Record(const std::string& id,
              const std::string& owner,
              int days_ago,
              const std::string& plan = "{}",
              RunState state = RunState::kFinished,
              const std::string& bench = "") {
    RunRecord record;
    record.id = id;
    record.owner = owner;
    record.source = "run";
    record.bench = bench;
    record.plan_json = plan;
    record.created_at = DaysAgo(days_ago);
    ASSERT_TRUE(store_.Begin(record).ok());
    ASSERT_TRUE(store_.AppendChunk(id, 0, std::vector<core::Sample>(1)).ok());
    if (state == RunState::kRunning) return;
    ASSERT_TRUE(store_.Finish(id, state, DaysAgo(days_ago), "{}", "nominal").ok());
  }
  void MakeJob(const std::string& id, const std::string& body, int ended_days_ago) {
    Job job;
    job.id = id;
    job.owner = "user:1";
    job.body = body;
    job.created_at = DaysAgo(ended_days_ago + 1);
    ASSERT_TRUE(jobs_.Add({job}).ok());
    if (ended_days_ago < 0) return;
    const Job claimed = *jobs_.Claim({"s", "boot"}, {}, job.created_at).value();
    ASSERT_EQ(claimed.id, id);
    ASSERT_TRUE(jobs_.SetRun(claimed, "run-of-" + id).ok());
    ASSERT_TRUE(jobs_.Finish(claimed, "finished", "", DaysAgo(ended_days_ago)).ok());
  }
  std::vector<std::string> Retained(bool remove) {
    const auto report = Retain(*database_, rules_, kToday, remove);
    EXPECT_TRUE(report.ok()) << report.error().message;
    std::vector<std::string> ids;
    for (const Expired& item : report.value().items) ids.push_back(item.kind + " " + item.id);
    std::sort(ids.begin(), ids.end());
    return ids;
  }
  bool There(const std::string& run) { return store_.Get(run).ok(); }

  tests::TestDatabase database_{GetParam()};
  RecordingStore store_{*database_};
  JobStore jobs_{*database_};
  Accounts accounts_{*database_, GuestAccess::kNever};
  RetentionRules rules_{.guest_days = 30, .student_days = 100, .job_days = 60, .news_days = 0};
};

TEST_P(RetentionTest, GuestsRecordingsGoAfterTheirDaysAndADryRunOnlySaysSo) {
  Record("old", "guest", 31);
  Record("new", "guest", 29);
  Record("mine", "user:7", 5000);
  PictureStore pictures(*database_);
  const StoredPicture end{.why = "end", .content_type = "image/jpeg"};
  for (const char* run : {"old", "new"}) ASSERT_TRUE(pictures.Add(run, end, "bytes").ok());
  EXPECT_THAT(Retained(false), ElementsAre("recording old"));
  EXPECT_TRUE(There("old")) << "a dry run deletes nothing";
  EXPECT_THAT(accounts_.ListAudit(0, 10).value(), IsEmpty());
  EXPECT_THAT(Retained(true), ElementsAre("recording old"));
  EXPECT_FALSE(There("old"));
  EXPECT_FALSE(pictures.Load("old", 1).ok()) << "with their pictures";
  EXPECT_TRUE(There("new"));
  EXPECT_TRUE(pictures.Load("new", 1).ok());
  EXPECT_TRUE(There("mine"));
  const auto log = accounts_.ListAudit(0, 10).value();
  ASSERT_EQ(log.size(), 1u);
  EXPECT_EQ(log[0].verb, "retention");
  EXPECT_THAT(Retained(true), IsEmpty()) << "and once is enough";
  EXPECT_TRUE(database_->Check().ok());
}

TEST_P(RetentionTest, AStudentsRecordingsStayUntilTheLastCourseHasLongEnded) {
  const std::int64_t teacher =
      accounts_.Create("teacher", "T", Role::kInstructor, kToday).value().id;
  const std::int64_t ann = accounts_.Create("ann", "A", Role::kStudent, kToday).value().id;
  const std::int64_t bob = accounts_.Create("bob", "B", Role::kStudent, kToday).value().id;
  const std::int64_t free = accounts_.Create("free", "F", Role::kStudent, kToday).value().id;
  const auto course = [&](std::optional<int> ended_days_ago, const std::vector<std::int64_t>& who) {
    const std::int64_t id = accounts_.CreateCourse("c", teacher, kToday).value().id;
    if (ended_days_ago) {
      EXPECT_TRUE(accounts_.SetCourseEnd(id, DaysAgo(*ended_days_ago)).ok());
    }
    for (const std::int64_t member : who) EXPECT_TRUE(accounts_.Enrol(id, member, false).ok());
  };
  course(200, {ann, bob});
  course(50, {bob});
  const auto owner = [](std::int64_t id) { return "user:" + std::to_string(id); };
  Record("ann", owner(ann), 210);
  Record("bob", owner(bob), 210);
  Record("free", owner(free), 5000);
  Record("teacher", owner(teacher), 5000);
  EXPECT_THAT(Retained(false), ElementsAre("recording ann"));
  course(std::nullopt, {ann});
  EXPECT_THAT(Retained(true), IsEmpty()) << "a course without an end keeps them";
}

TEST_P(RetentionTest, AJobGoesWithTheRecordingOfItsRun) {
  MakeJob("old", "{}", 61);
  Record("run-of-old", "user:1", 61);
  MakeJob("new", "{}", 10);
  Record("run-of-new", "user:1", 10);
  EXPECT_THAT(Retained(true), ElementsAre("job old", "recording run-of-old"));
  EXPECT_FALSE(jobs_.Get("old").ok());
  EXPECT_TRUE(jobs_.Get("new").ok());
  EXPECT_TRUE(There("run-of-new"));
}

TEST_P(RetentionTest, NothingInUseIsDeletedHoweverOld) {
  Record("runs", "guest", 400, "{}", RunState::kRunning);
  Record("replayed", "guest", 400);
  Record("replay", "guest", 0, R"({"recording":"replayed"})", RunState::kRunning);
  Record("wanted", "guest", 400);
  MakeJob("waits", R"({"diagnose":{"recording":"wanted"}})", -1);
  EXPECT_THAT(Retained(true), IsEmpty());
}

TEST_P(RetentionTest, ZeroDaysMeanForEver) {
  rules_ = {0, 0, 0, 0};
  Record("old", "guest", 10'000);
  MakeJob("old", "{}", 9000);
  EXPECT_THAT(Retained(true), IsEmpty());
}

TEST_P(RetentionTest, BenchesThatNothingNamesGoAndTheOthersStay) {
  BenchStore benches(*database_);
  RigCalibrations calibrations(*database_);
  for (const char* id : {"of a rig", "of a run", "learnt", "tried once", "renewed"}) {
    ASSERT_TRUE(benches.Add(id, "text", DaysAgo(41)).ok());
  }
  ASSERT_TRUE(benches.PutRigs({{"bench-1", "of a rig"}}).ok());
  Record("run", "user:1", 41, "{}", RunState::kFinished, "of a run");
  RigCalibration calibration;
  calibration.rig = "bench-1";
  calibration.run = "x";
  calibration.bench = "learnt";
  ASSERT_TRUE(calibrations.Add(calibration).ok());
  ASSERT_TRUE(benches.Add("renewed", "text", DaysAgo(39)).ok());
  EXPECT_EQ(Retain(*database_, rules_, kToday, /*remove=*/false).value().benches, 1);
  EXPECT_EQ(benches.Text("tried once").value(), "text") << "a dry run deletes nothing";
  EXPECT_EQ(Retain(*database_, rules_, kToday, /*remove=*/true).value().benches, 1);
  EXPECT_EQ(benches.Text("tried once").value(), "");
  for (const char* id : {"of a rig", "of a run", "learnt", "renewed"}) {
    EXPECT_EQ(benches.Text(id).value(), "text") << id;
  }
  EXPECT_EQ(Retain(*database_, rules_, kToday, /*remove=*/true).value().benches, 0);
}

INSTANTIATE_TEST_SUITE_P(Engines, RetentionTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server
