#include "server/run/run_recovery.h"

#include <gmock/gmock.h>

#include "server/run/run_messages.h"
#include "tests/server/run/run_fixture.h"

namespace faultlab::server {
namespace {

using hardware::RigEvent;
using hardware::RigEventKind;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class RunRecoveryTest : public tests::RunFixture {
 protected:
  /// A run of which 100 samples and its first event are stored.
  RunRecoveryTest() {
    RunRecord record;
    record.id = kRun;
    record.owner = "guest";
    record.rig = "fake-1";
    record.source = "run";
    record.server_id = "local";
    record.period_s = 0.01;
    record.kept_run = "7/3";
    rig_->kept_run_ = "7/3";
    EXPECT_TRUE(store_->Begin(record).ok());
    std::vector<core::Sample> samples;
    for (std::int64_t i = 0; i < 100; ++i) samples.push_back(SampleAt(i));
    EXPECT_TRUE(store_->AppendChunk(kRun, 0, samples).ok());
    const std::vector<RecordedEvent> events = {MakeEvent(kStarted, 0.01)};
    EXPECT_TRUE(store_->AppendEvents(kRun, events).ok());
    EXPECT_TRUE(database_
                    ->Write(Durability::kPromise,
                            [&](Transaction& tx) -> core::Status {
                              (void)InterruptRuns(tx, "local", clock_.Wall());
                              return core::Done{};
                            })
                    .ok());
  }
  void Say(std::int64_t from, std::int64_t to) {
    for (std::int64_t i = from; i < to; ++i) rig_->Say(SampleAt(i));
  }
  RunRecord Record() { return store_->Get(kRun).value(); }
  RunRecovery Rest() { return RunRecovery(rig_, *store_, Record()); }
  /// Reads until the recording is closed.
  void Read(RunRecovery& rest) {
    for (int i = 0; i < 3; ++i) {
      const auto closed = rest.Step();
      ASSERT_TRUE(closed.ok()) << closed.error().message;
      if (closed.value()) return;
    }
    ADD_FAILURE() << "not closed";
  }
  std::vector<std::int64_t> Indices() {
    std::vector<std::int64_t> indices;
    const auto samples = store_->LoadSamples(kRun);
    for (const core::Sample& sample : samples.value()) indices.push_back(sample.index);
    return indices;
  }
  static std::vector<std::int64_t> Counted(std::int64_t end) {
    std::vector<std::int64_t> indices;
    for (std::int64_t i = 0; i < end; ++i) indices.push_back(i);
    return indices;
  }

  static constexpr const char* kRun = "run-1";
  static inline const RigEvent kStarted{.kind = RigEventKind::kStarted, .text = {}};
  std::shared_ptr<tests::FakeRig> rig_ = std::make_shared<tests::FakeRig>();
};

TEST_F(RunRecoveryTest, AddsWhatIsMissingAndNothingTwice) {
  rig_->Say(kStarted);
  Say(0, 234);
  rig_->Say(RigEvent{.kind = RigEventKind::kStopped, .index = 234, .text = "watchdog: silence"});
  rig_->End();
  RunRecovery rest = Rest();
  ASSERT_TRUE(rest.Begin().ok());
  Read(rest);
  EXPECT_EQ(Indices(), Counted(234));
  EXPECT_THAT(Kinds(kRun), ElementsAre("started", "stopped", "rest_fetched"));
  EXPECT_THAT(store_->LoadEvents(kRun).value()[1].json, HasSubstr("watchdog: silence"));
  EXPECT_THAT(store_->LoadEvents(kRun).value()[2].json, HasSubstr("\"value\":134"));
  EXPECT_EQ(Record().state, RunState::kInterrupted);
  EXPECT_FALSE(Record().AwaitsRecovery());
}

TEST_F(RunRecoveryTest, IsBegunAgainAfterAnotherCut) {
  rig_->Say(kStarted);
  Say(0, 250);
  {
    RunRecovery cut = Rest();
    ASSERT_TRUE(cut.Begin().ok());
    EXPECT_FALSE(cut.Step().value());
  }
  EXPECT_EQ(Indices(), Counted(200)) << "whole seconds are stored while the run goes on";
  EXPECT_TRUE(Record().AwaitsRecovery());
  rig_->Say(kStarted);
  Say(0, 300);
  rig_->Say(RigEvent{.kind = RigEventKind::kFinished, .index = 300, .text = {}});
  rig_->End();
  RunRecovery rest = Rest();
  ASSERT_TRUE(rest.Begin().ok());
  Read(rest);
  EXPECT_EQ(Indices(), Counted(300));
  EXPECT_EQ(Record().state, RunState::kFinished);
}

TEST_F(RunRecoveryTest, SaysWhichSamplesTheRigHasLost) {
  rig_->Say(RigEvent{.kind = RigEventKind::kGap, .index = 0, .value = 151, .text = {}});
  Say(150, 160);
  rig_->Say(RigEvent{.kind = RigEventKind::kTrip, .index = 160, .text = "stall: blocked"});
  rig_->Say(RigEvent{.kind = RigEventKind::kStopped, .index = 160, .text = "stall"});
  rig_->End();
  RunRecovery rest = Rest();
  ASSERT_TRUE(rest.Begin().ok());
  Read(rest);
  EXPECT_EQ(Indices().size(), 110u);
  EXPECT_THAT(Kinds(kRun), ElementsAre("started", "gap", "trip", "stopped", "rest_fetched"));
  const std::string gap = store_->LoadEvents(kRun).value()[1].json;
  EXPECT_THAT(gap, HasSubstr("\"index\":100"));
  EXPECT_EQ(Record().state, RunState::kFailed);
}

TEST_F(RunRecoveryTest, OfWhatIsStoredAlreadyTheRigMayHaveLostAnything) {
  rig_->Say(RigEvent{.kind = RigEventKind::kGap, .index = 0, .value = 80, .text = {}});
  Say(80, 120);
  rig_->Say(RigEvent{.kind = RigEventKind::kFinished, .index = 120, .text = {}});
  rig_->End();
  RunRecovery rest = Rest();
  ASSERT_TRUE(rest.Begin().ok());
  Read(rest);
  EXPECT_EQ(Indices(), Counted(120));
  EXPECT_THAT(Kinds(kRun), Not(testing::Contains("gap")));
}

TEST_F(RunRecoveryTest, OfARigThatHasAnotherRunIsNotRead) {
  rig_->kept_run_ = "8/1";
  RunRecovery rest = Rest();
  EXPECT_EQ(rest.Begin().error().code, core::ErrorCode::kNotFound);
  EXPECT_TRUE(Record().AwaitsRecovery()) << "its caller decides";
}

TEST_F(RunRecoveryTest, IsKeptFromDeletionUntilItIsClosed) {
  const core::Status refused = store_->Delete(kRun);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().reason, "rest_awaited");
  EXPECT_FALSE(store_->OldestEndedOf("guest").value());
  ASSERT_TRUE(store_->EndRecovery(kRun, RunState::kInterrupted, {}).ok());
  EXPECT_EQ(store_->OldestEndedOf("guest").value(), kRun);
  EXPECT_TRUE(store_->Delete(kRun).ok());
}

TEST_F(RunRecoveryTest, AfterItsEndNothingIsAdded) {
  ASSERT_TRUE(store_->EndRecovery(kRun, RunState::kInterrupted, {}).ok());
  const std::vector<core::Sample> more = {SampleAt(100)};
  EXPECT_EQ(store_->AppendRecovered(kRun, more).error().code, core::ErrorCode::kConflict);
  const std::vector<RecordedEvent> events = {MakeEvent(kStarted, 0.01)};
  ASSERT_TRUE(store_->EndRecovery(kRun, RunState::kFinished, events).ok());
  EXPECT_EQ(Record().state, RunState::kInterrupted);
  EXPECT_EQ(Kinds(kRun).size(), 1u);
}

TEST_F(RunRecoveryTest, OfARunningRunCannotBeAdded) {
  RunRecord running;
  running.id = "run-2";
  running.kept_run = "7/4";
  ASSERT_TRUE(store_->Begin(running).ok());
  const std::vector<core::Sample> more = {SampleAt(0)};
  EXPECT_EQ(store_->AppendRecovered("run-2", more).error().code, core::ErrorCode::kConflict);
  EXPECT_EQ(store_->AwaitingRecovery().value().size(), 1u);
}

}  // namespace
}  // namespace faultlab::server
