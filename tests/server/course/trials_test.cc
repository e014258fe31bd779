#include "server/course/trials.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>

#include "hardware/rig.h"
#include "server/course/assignments.h"
#include "server/course/trial_witness.h"
#include "tests/paper_bench.h"
#include "tests/support/temp_folder.h"

namespace faultlab::server::course {
namespace {

constexpr WallTime kNow{std::chrono::milliseconds(1'700'000'000'000)};

class TestClock : public Clock {
 public:
  MonotonicTime Monotonic() const override { return {}; }
  WallTime Wall() const override { return kNow; }
};

class TrialsTest : public ::testing::Test {
 protected:
  TrialsTest()
      : database_(std::move(Database::Open({.location = folder_.File("test.db")})).value()),
        trials_(*database_) {}

  core::Result<Trial> Add(int attempts = 1,
                          WallTime now = kNow,
                          std::optional<std::chrono::milliseconds> limit = std::nullopt) {
    return trials_.Add(
        5, 7, attempts, now, limit, [this](const std::vector<Trial>& former, Trial& of) {
          former_ = former.size();
          of.truth = "{}";
          of.item = 2;
        });
  }
  TrialState StateOf(std::int64_t id) { return trials_.Get(id).value().state; }
  static std::string ReasonOf(const core::Status& status) {
    return status.ok() ? "" : status.error().reason;
  }

  tests::TempFolder folder_;
  std::unique_ptr<Database> database_;
  Trials trials_;
  TestClock clock_;
  std::size_t former_ = 0;
};

TEST_F(TrialsTest, GoFromTheDrawToTheRelease) {
  const std::int64_t id = Add().value().id;
  EXPECT_EQ(StateOf(id), TrialState::kDrawn);
  EXPECT_EQ(ReasonOf(trials_.Answer(id, "[]", "{}", "{}", 1, "[]", kNow)), "trial_changed");
  ASSERT_TRUE(trials_.Began(id, "run-1").ok());
  EXPECT_EQ(StateOf(id), TrialState::kRunning);
  ASSERT_TRUE(trials_.Ended(id, R"(["it's"])", kNow).ok());
  EXPECT_EQ(ReasonOf(trials_.Ended(id, "[]", kNow)), "trial_changed");
  ASSERT_TRUE(trials_
                  .Answer(id,
                          "[]",
                          R"({"text":"a ':now' in words"})",
                          R"({"points":5})",
                          1,
                          R"(["it's"])",
                          kNow)
                  .ok());
  EXPECT_EQ(ReasonOf(trials_.Answer(id, "[]", "{}", "{}", 1, "[]", kNow)), "trial_changed")
      << "the first counts";
  EXPECT_EQ(ReasonOf(trials_.Void(id, "rig_failed", kNow)), "trial_changed");
  ASSERT_TRUE(trials_.Release(id, kNow).ok());
  const Trial trial = trials_.Get(id).value();
  EXPECT_EQ(trial.state, TrialState::kAnswered);
  EXPECT_EQ(trial.run, "run-1");
  EXPECT_EQ(trial.item, 2);
  EXPECT_EQ(trial.events, R"(["it's"])");
  EXPECT_EQ(trial.answer, R"({"text":"a ':now' in words"})");
  EXPECT_EQ(trial.released_at, kNow);
}

TEST_F(TrialsTest, AHintThatComesBetweenIsPaid) {
  const std::int64_t id = Add().value().id;
  ASSERT_TRUE(trials_.Began(id, "run-1").ok());
  EXPECT_EQ(ReasonOf(trials_.TakeHint(id, "[]", "[1]")), "trial_changed") << "its run goes on";
  ASSERT_TRUE(trials_.Ended(id, "[]", kNow).ok());
  ASSERT_TRUE(trials_.TakeHint(id, "[]", "[1]").ok());
  EXPECT_EQ(ReasonOf(trials_.TakeHint(id, "[]", "[1]")), "trial_changed") << "two at once";
  EXPECT_EQ(ReasonOf(trials_.Answer(id, "[]", "{}", "{}", 1, "[]", kNow)), "trial_changed")
      << "graded without it";
  EXPECT_TRUE(trials_.Answer(id, "[1]", "{}", "{}", 1, "[]", kNow).ok());
  EXPECT_EQ(ReasonOf(trials_.TakeHint(id, "[1]", "[1,2]")), "trial_changed");
}

TEST_F(TrialsTest, TakeNoAnswerAfterTheRelease) {
  const std::int64_t id = Add().value().id;
  ASSERT_TRUE(trials_.Ended(id, "[]", kNow).ok());
  ASSERT_TRUE(trials_.Release(id, kNow).ok());
  EXPECT_EQ(ReasonOf(trials_.Answer(id, "[]", "{}", "{}", 1, "[]", kNow)), "trial_changed");
}

TEST_F(TrialsTest, OfARunThatCouldNotBeginNothingStays) {
  const std::int64_t id = Add().value().id;
  ASSERT_TRUE(trials_.Forget(id).ok());
  EXPECT_FALSE(trials_.Get(id).ok());
  const std::int64_t next = Add().value().id;
  EXPECT_EQ(former_, 0U);
  ASSERT_TRUE(trials_.Began(next, "run-1").ok());
  ASSERT_TRUE(trials_.Forget(next).ok());
  EXPECT_EQ(StateOf(next), TrialState::kRunning) << "of one that has begun everything does";
}

TEST_F(TrialsTest, ARunMayEndBeforeItsBeginIsStored) {
  const std::int64_t id = Add().value().id;
  ASSERT_TRUE(trials_.Ended(id, "[]", kNow).ok());
  ASSERT_TRUE(trials_.Began(id, "run-1").ok());
  EXPECT_EQ(StateOf(id), TrialState::kOpen);
  EXPECT_EQ(trials_.Get(id).value().run, "run-1");
}

TEST_F(TrialsTest, AreOneAtATimeAndAsManyAsAttempts) {
  const std::int64_t one = Add(2).value().id;
  EXPECT_EQ(Add(2).error().reason, "trial_open");
  ASSERT_TRUE(trials_.Void(one, "interrupted", kNow).ok());
  for (int n = 0; n < 2; ++n) {
    const auto next = Add(2);
    ASSERT_TRUE(next.ok()) << next.error().message;
    EXPECT_EQ(former_, static_cast<std::size_t>(n + 1)) << "a void one is not drawn again";
    ASSERT_TRUE(trials_.Ended(next.value().id, "[]", kNow).ok());
    ASSERT_TRUE(trials_.Answer(next.value().id, "[]", "{}", "{}", 1, "[]", kNow).ok());
  }
  EXPECT_EQ(Add(2).error().reason, "attempts_used");
  EXPECT_EQ(trials_.Of(5, 7, 0, 10).value().size(), 3U);
  EXPECT_EQ(trials_.Of(5, 8, 0, 10).value().size(), 0U);
  EXPECT_EQ(trials_.Of(5, std::nullopt, one, 1).value().size(), 1U);
}

TEST_F(TrialsTest, OneWhoseTimeIsOverCountsAndIsInNobodysWay) {
  constexpr std::chrono::minutes kLimit{25};
  const std::int64_t id = Add(2, kNow, kLimit).value().id;
  ASSERT_TRUE(trials_.Ended(id, "[]", kNow).ok());
  const WallTime last = kNow + kLimit - std::chrono::milliseconds(1);
  EXPECT_EQ(Add(2, last, kLimit).error().reason, "trial_open");
  EXPECT_EQ(Add(1, kNow + kLimit, kLimit).error().reason, "attempts_used");
  EXPECT_TRUE(Add(2, kNow + kLimit, kLimit).ok());
}

class WitnessTest : public TrialsTest {
 protected:
  static constexpr lab::SessionId kEndedByUser{5};

  const core::Component r1_ = *paper::Bench().Find("R1");

  hardware::RigEvent Confirmed(core::Component component, double value) const {
    return {hardware::RigEventKind::kRelayConfirmed, 800, component, value, ""};
  }
  /// What becomes of a trial with R1 = 60 ohm at 8 s.
  std::string EndWith(const std::vector<hardware::RigEvent>& events,
                      RunState state,
                      double length_s,
                      bool tripped = false,
                      std::optional<core::Fault> drawn = std::nullopt) {
    const std::int64_t id = Add(100).value().id;
    const core::Fault fault =
        drawn.value_or(core::Fault{r1_, 60.0, 8.0, core::FaultKind::kAbrupt, 0.0});
    return EndWith(events,
                   id,
                   fault,
                   {.state = state, .tripped = tripped, .by_owner = true, .length_s = length_s});
  }
  std::string EndWith(const std::vector<hardware::RigEvent>& events,
                      std::int64_t id,
                      const core::Fault& fault,
                      const SealedEnd& end) {
    const auto by_user = [](lab::SessionId session) { return session == kEndedByUser; };
    const auto witness = MakeWitness(trials_, id, {fault}, by_user, clock_, [](auto) {});
    for (const hardware::RigEvent& event : events) witness->OnEvent(event, 0.01);
    witness->OnEnd(end);
    const Trial trial = trials_.Get(id).value();
    if (trial.state == TrialState::kOpen) {
      EXPECT_TRUE(trials_.Answer(id, "[]", "{}", "{}", 1, "[]", kNow).ok());
      return "stands";
    }
    return trial.why;
  }
};

TEST_F(WitnessTest, TakesWhatTheRelaysSayForTheTruth) {
  const std::vector<hardware::RigEvent> right = {Confirmed(r1_, 60.0)};
  EXPECT_EQ(EndWith(right, RunState::kFinished, 20.0), "stands");
  EXPECT_EQ(EndWith({}, RunState::kFinished, 20.0), "relay_mismatch");
  EXPECT_EQ(EndWith({Confirmed(r1_, 61.0)}, RunState::kFinished, 20.0), "relay_mismatch");
  EXPECT_EQ(EndWith({Confirmed(r1_, 60.0), Confirmed(*paper::Bench().Find("R9"), 1e4)},
                    RunState::kFinished,
                    20.0),
            "relay_mismatch");
  EXPECT_EQ(
      EndWith(
          {{hardware::RigEventKind::kRefused, 800, r1_, 60.0, "no"}}, RunState::kFinished, 20.0),
      "relay_mismatch");
}

TEST_F(WitnessTest, ADriftIsConfirmedAtItsEnd) {
  const core::Fault drift{r1_, 60.0, 8.0, core::FaultKind::kDrift, 12.0};
  EXPECT_EQ(EndWith({}, RunState::kStopped, 10.0, false, drift), "stands")
      << "whoever stops in the midst of it has used the attempt";
  EXPECT_EQ(EndWith({}, RunState::kFinished, 14.0, false, drift), "relay_mismatch");
  EXPECT_EQ(EndWith({Confirmed(r1_, 59.9)}, RunState::kFinished, 14.0, false, drift), "stands");
}

TEST_F(WitnessTest, GivesTheAttemptBackOnlyWhenTheRigFailed) {
  EXPECT_EQ(EndWith({}, RunState::kStopped, 5.0), "stands") << "whoever stops has used it";
  EXPECT_EQ(EndWith({Confirmed(r1_, 60.0)}, RunState::kFailed, 12.0, true), "stands")
      << "an interlock acted, as it does with this fault";
  EXPECT_EQ(EndWith({Confirmed(r1_, 60.0)}, RunState::kFailed, 12.0), "rig_failed");
  EXPECT_EQ(EndWith({}, RunState::kFailed, 5.0, true), "rig_failed") << "its fault never came";
}

TEST_F(WitnessTest, GivesTheAttemptBackWhenTheLabCutTheRun) {
  const core::Fault fault{r1_, 60.0, 8.0, core::FaultKind::kAbrupt, 0.0};
  const auto cut = [&](lab::SessionId session) {
    return EndWith({},
                   Add(100).value().id,
                   fault,
                   {.state = RunState::kStopped, .revoked = session, .length_s = 5.0});
  };
  EXPECT_EQ(cut({}), "interrupted") << "the server stops";
  EXPECT_EQ(cut(lab::SessionId{6}), "session_ended");
  EXPECT_EQ(cut(kEndedByUser), "stands")
      << "or whoever does not like a fault would end the session";
  EXPECT_EQ(EndWith({},
                    Add(100).value().id,
                    fault,
                    {.state = RunState::kStopped, .by_another = true, .length_s = 5.0}),
            "stopped_by_another");
}

TEST_F(TrialsTest, AnAssignmentKeepsItsOwnPool) {
  Assignments assignments(*database_);
  Assignment of;
  of.course = 3;
  of.name = "Exercise";
  of.pool_json = R"({"items":[]})";
  of.opens = kNow;
  of.due = kNow + std::chrono::hours(1);
  of.attempts = 4;
  of.reveal_at_once = true;
  of.secret = "s";
  const auto made = assignments.Create(of);
  ASSERT_TRUE(made.ok()) << made.error().message;
  const Assignment read = assignments.Get(made.value().id).value();
  EXPECT_EQ(read.pool_json, of.pool_json);
  EXPECT_EQ(read.due, of.due);
  EXPECT_EQ(read.attempts, 4);
  EXPECT_TRUE(read.reveal_at_once);
  EXPECT_EQ(assignments.List(std::nullopt, 0, 10).value().size(), 1U);
  EXPECT_EQ(assignments.List(77, 0, 10).value().size(), 0U) << "not in the course";
  ASSERT_TRUE(assignments.Delete(made.value().id).ok());
  EXPECT_EQ(assignments.List(std::nullopt, 0, 10).value().size(), 0U);
  EXPECT_TRUE(assignments.Get(made.value().id).ok()) << "its trials can still be read";
}

}  // namespace
}  // namespace faultlab::server::course
