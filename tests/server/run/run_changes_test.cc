// Changes of the rig while a run calibrates its model of the healthy rig.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <functional>
#include <optional>
#include <thread>

#include "hardware/replay_rig.h"
#include "server/run/run_messages.h"
#include "tests/paper_rig.h"
#include "tests/server/run/run_fixture.h"

namespace faultlab::server {
namespace {

using core::Component;
using tests::FakeRig;
using Kind = hardware::RigCommand::Kind;

constexpr hardware::Epoch kEpoch{1};

hardware::RigCommand Set(Component component, double value) {
  return {Kind::kSetComponent, component, value};
}

/// Acts with exact timing: on the run's own thread, at one sample.
class AtSample : public RunTap {
 public:
  using Deed = std::function<void(const std::string& run, hardware::Epoch epoch)>;
  AtSample(std::int64_t index, Deed deed) : index_(index), deed_(std::move(deed)) {}

  std::unique_ptr<RunTapStream> Open(const std::string&,
                                     const std::string& run,
                                     hardware::Epoch epoch) override {
    return std::make_unique<Stream>(*this, run, epoch);
  }

 private:
  struct Stream : RunTapStream {
    Stream(AtSample& tap, std::string of, hardware::Epoch at)
        : owner(tap), run(std::move(of)), epoch(at) {}
    void OnFrame(const core::Frame& frame) override {
      if (frame.sample.index == owner.index_) owner.deed_(run, epoch);
    }
    void OnEvent(const hardware::RigEvent&, double) override {}
    AtSample& owner;
    std::string run;
    hardware::Epoch epoch;
  };

  const std::int64_t index_;
  const Deed deed_;
};

class RunChangesTest : public tests::RunFixture {
 protected:
  /// Starts a run on `rig` and returns its id.
  std::string Begin(const std::shared_ptr<FakeRig>& rig) {
    auto started = manager_->Start(Scripted(rig));
    EXPECT_TRUE(started.ok());
    return started.value().id;
  }
  /// Samples [from, to) under a constant voltage, which is not enough for a calibration.
  static void Play(FakeRig& rig, int from, int to) {
    for (int i = from; i < to; ++i) rig.Say(SampleAt(i));
  }
  /// A run may have begun before Start has returned.
  void AwaitKnown(const std::string& run) const {
    while (!manager_->Find(run)) std::this_thread::yield();
  }
  void Finish(FakeRig& rig, const std::string& id) {
    hardware::RigEvent finished;
    finished.kind = hardware::RigEventKind::kFinished;
    rig.Say(finished);
    rig.End();
    manager_->Wait(id);
  }
  std::optional<RecordedEvent> FirstOf(const std::string& id, std::string_view kind) {
    const auto events = store_->LoadEvents(id);
    for (const RecordedEvent& event : events.value()) {
      if (event.kind == kind) return event;
    }
    return std::nullopt;
  }
  std::string TextOf(const std::string& id, std::string_view kind) {
    const auto event = FirstOf(id, kind);
    if (!event) return "no event " + std::string(kind);
    const auto object = boost::json::parse(event->json).as_object();
    return std::string(object.at("text").as_string());
  }
};

TEST_F(RunChangesTest, AChangeInTheFirstSecondWaitsAndIsNamedAsIfItCameAfterTheLearning) {
  std::optional<Accepted> answer;
  AtSample second(100, [&](const std::string& run, hardware::Epoch epoch) {
    AwaitKnown(run);
    auto taken = manager_->Command(run, epoch, Set(paper::kR1, 100.0));
    if (taken.ok()) answer = taken.value();
  });
  manager_->SetTap(&second);
  RunRequest request = Paper();
  request.plan.faults.clear();
  const RunRecord record = RunToEnd(std::move(request));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->waits_until_s, 5.0);
  EXPECT_EQ(record.verdict, "fault") << record.diagnosis_json;
  const auto diagnosis = boost::json::parse(record.diagnosis_json).as_object();
  EXPECT_EQ(diagnosis.at("candidates").at(0).at("component"), "R1");
  EXPECT_NEAR(diagnosis.at("candidates").at(0).at("value").to_number<double>(), 100.0, 3.0);

  const auto waits = FirstOf(record.id, "change_waits");
  const auto learnt = FirstOf(record.id, "learnt");
  const auto commanded = FirstOf(record.id, "fault_commanded");
  ASSERT_TRUE(waits && learnt && commanded);
  EXPECT_GE(waits->index, 100);
  EXPECT_LE(waits->index, 140);
  EXPECT_EQ(TextOf(record.id, "change_waits"), "until the healthy rig is learnt, at 5 s");
  EXPECT_GE(commanded->index, 500);
  EXPECT_LE(commanded->index, 540);
  EXPECT_GE(learnt->index, 500);
}

TEST_F(RunChangesTest, TheNewestForAComponentWinsAndNominalTakesItBack) {
  auto rig = std::make_shared<FakeRig>();
  const std::string id = Begin(rig);
  for (const auto& change : {Set(paper::kR1, 10.0),
                             Set(paper::kR1, 56.0),
                             Set(paper::kR12, 2e3),
                             Set(paper::kC8, 1e-6)}) {
    const auto taken = manager_->Command(id, kEpoch, change);
    ASSERT_TRUE(taken.ok());
    EXPECT_EQ(taken.value().waits_until_s, 5.0);
  }
  const auto back = manager_->Command(id, kEpoch, Set(paper::kR12, 10e3));
  ASSERT_TRUE(back.ok());
  EXPECT_FALSE(back.value().waits_until_s) << "a return to nominal needs no waiting";
  ASSERT_EQ(rig->commands().size(), 1u);
  Play(*rig, 0, 500);
  Play(*rig, 500, 520);
  rig->AwaitCommands(3);
  Finish(*rig, id);
  const auto told = rig->commands();
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(told[1].component, paper::kR1);
  EXPECT_EQ(told[1].value, 56.0);
  EXPECT_EQ(told[2].component, paper::kC8);
  EXPECT_TRUE(FirstOf(id, "change_dropped"));
}

TEST_F(RunChangesTest, AllNominalTakesBackWhatWaits) {
  auto rig = std::make_shared<FakeRig>();
  const std::string id = Begin(rig);
  ASSERT_TRUE(manager_->Command(id, kEpoch, Set(paper::kR1, 100.0)).ok());
  ASSERT_TRUE(manager_->Command(id, kEpoch, {}).ok());
  Play(*rig, 0, 600);
  Finish(*rig, id);
  ASSERT_EQ(rig->commands().size(), 1u);
  EXPECT_EQ(rig->commands()[0].kind, Kind::kAllNominal);
  EXPECT_TRUE(FirstOf(id, "change_dropped"));
}

TEST_F(RunChangesTest, GoesToTheRigAtOnceAfterTheLearning) {
  auto rig = std::make_shared<FakeRig>();
  const std::string id = Begin(rig);
  ASSERT_TRUE(manager_->Command(id, kEpoch, Set(paper::kR9, 33e3)).ok());
  Play(*rig, 0, 501);
  rig->AwaitCommands(1);
  // Earlier changes have been sent; a new change may still find the last of them in progress.
  auto taken = manager_->Command(id, kEpoch, Set(paper::kR1, 10.0));
  ASSERT_TRUE(taken.ok());
  rig->AwaitCommands(2);
  EXPECT_EQ(rig->commands()[1].component, paper::kR1);
  Finish(*rig, id);
}

TEST_F(RunChangesTest, InRealTimeTheRunDoesNotWaitForTheRigsAnswer) {
  Manage(1.0);
  auto rig = std::make_shared<FakeRig>();
  const std::string id = Begin(rig);
  ASSERT_TRUE(manager_->Command(id, kEpoch, Set(paper::kR1, 100.0)).ok());
  Play(*rig, 0, 501);
  rig->AwaitCommands(1);
  EXPECT_EQ(rig->commands()[0].value, 100.0);
  Finish(*rig, id);
}

TEST_F(RunChangesTest, ActsAllTheSameWhenTheRigCannotBeLearnt) {
  auto rig = std::make_shared<FakeRig>();
  const std::string id = Begin(rig);
  ASSERT_TRUE(manager_->Command(id, kEpoch, Set(paper::kR1, 100.0)).ok());
  Play(*rig, 0, 520);
  rig->AwaitCommands(1);
  Finish(*rig, id);
  EXPECT_FALSE(FirstOf(id, "learnt"));
  EXPECT_NE(TextOf(id, "not_learnt").find("excit"), std::string::npos) << TextOf(id, "not_learnt");
}

TEST_F(RunChangesTest, ARunWhoseStretchWasSpoiltLearnsAgainAndNamesWhatComesLater) {
  std::optional<core::Result<Accepted>> early, late;
  std::optional<Accepted> waiting;
  AtSample seventh(700, [&](const std::string& run, hardware::Epoch epoch) {
    AwaitKnown(run);
    late = manager_->LearnAgain(run);
    auto taken = manager_->Command(run, epoch, Set(paper::kR12, 2e3));
    if (taken.ok()) waiting = taken.value();
    (void)manager_->Command(run, epoch, Set(paper::kR12, 10e3));
  });
  AtSample third(300, [&](const std::string& run, hardware::Epoch) {
    AwaitKnown(run);
    early = manager_->LearnAgain(run);
  });
  manager_->SetTap(&third);
  RunRequest first = Paper();
  const auto spoilt = [](RunRequest& request) {
    request.plan.faults = {{paper::kR1, 10.0, 2.0, core::FaultKind::kAbrupt, 0.0},
                           {paper::kR1, 1.0, 6.0, core::FaultKind::kAbrupt, 0.0},
                           {paper::kR1, 100.0, 14.0, core::FaultKind::kAbrupt, 0.0}};
  };
  spoilt(first);
  EXPECT_EQ(RunToEnd(std::move(first)).verdict, "calibrating");
  ASSERT_TRUE(early);
  ASSERT_FALSE(early->ok()) << "R1 is not nominal";
  EXPECT_EQ(early->error().reason, "not_nominal");
  EXPECT_EQ(early->error().parameters.front().value, "R1");

  manager_->SetTap(&seventh);
  RunRequest second = Paper();
  spoilt(second);
  const RunRecord record = RunToEnd(std::move(second));
  ASSERT_TRUE(late && late->ok());
  ASSERT_TRUE(waiting);
  EXPECT_TRUE(waiting->waits_until_s) << "a change waits again";
  const auto learning = FirstOf(record.id, "learning");
  ASSERT_TRUE(learning);
  EXPECT_EQ(learning->index, 701);
  const auto until = boost::json::parse(learning->json).as_object().at("value").to_number<double>();
  EXPECT_NEAR(until, 7.01 + 4.5, 1e-9);
  EXPECT_TRUE(FirstOf(record.id, "not_learnt"));
  EXPECT_TRUE(FirstOf(record.id, "learnt"));
  EXPECT_EQ(record.verdict, "fault") << record.diagnosis_json;
  const auto options = boost::json::parse(record.options_json).as_object();
  EXPECT_NEAR(options.at("healthy_from_s").to_number<double>(), 7.01, 1e-9)
      << "a repair of the diagnosis learns from the same stretch";
}

TEST_F(RunChangesTest, LearnsAgainOnlyWhenTheStretchFitsIntoThePlan) {
  std::optional<core::Result<Accepted>> planned;
  AtSample sixth(600, [&](const std::string& run, hardware::Epoch) {
    AwaitKnown(run);
    planned = manager_->LearnAgain(run);
  });
  manager_->SetTap(&sixth);
  RunToEnd(Paper());
  ASSERT_TRUE(planned);
  ASSERT_FALSE(planned->ok());
  EXPECT_EQ(planned->error().reason, "change_planned");
  manager_->SetTap(&sixth);
  RunToEnd(Paper(9.0));
  ASSERT_FALSE(planned->ok());
  EXPECT_EQ(planned->error().reason, "run_too_short");
  manager_->SetTap(&sixth);
  RunRequest hidden = Paper(30.0);
  hidden.plan.faults.clear();
  const RunRecord record = RunToEnd(std::move(hidden));
  EXPECT_TRUE(planned->ok());
  EXPECT_EQ(manager_->LearnAgain(record.id).error().reason, "run_ended");
}

TEST_F(RunChangesTest, ASecondChangeOfTheSameFaultIsToldAsDetectedOnce) {
  RunRequest request = Paper();
  request.plan.faults = {{paper::kR1, 10.0, 8.0, core::FaultKind::kAbrupt, 0.0},
                         {paper::kR1, 56.0, 14.0, core::FaultKind::kAbrupt, 0.0}};
  const RunRecord record = RunToEnd(std::move(request));
  const auto events = store_->LoadEvents(record.id);
  std::vector<std::int64_t> detected;
  for (const RecordedEvent& event : events.value()) {
    if (event.kind == "detected") detected.push_back(event.index);
  }
  ASSERT_EQ(detected.size(), 2u);
  EXPECT_NEAR(static_cast<double>(detected[0]), 800.0, 2.0);
  EXPECT_NEAR(static_cast<double>(detected[1]), 1400.0, 2.0);
}

TEST_F(RunChangesTest, DiesWithTheRun) {
  auto rig = std::make_shared<FakeRig>();
  const std::string id = Begin(rig);
  ASSERT_TRUE(manager_->Command(id, kEpoch, Set(paper::kR1, 100.0)).ok());
  Play(*rig, 0, 100);
  EXPECT_TRUE(manager_->Stop(id, "enough").ok());
  manager_->Wait(id);
  EXPECT_TRUE(rig->commands().empty());
  EXPECT_TRUE(FirstOf(id, "change_waits"));
  EXPECT_FALSE(manager_->Command(id, kEpoch, Set(paper::kR1, 10.0)).ok());
}

TEST_F(RunChangesTest, TheRigHasTheLastWordWhenTheWaitingIsOver) {
  auto rig = std::make_shared<FakeRig>();
  const std::string id = Begin(rig);
  ASSERT_TRUE(manager_->Command(id, kEpoch, Set(paper::kR1, 100.0)).ok());
  Play(*rig, 0, 100);
  rig->Fence(hardware::Epoch{2});  // another lease has the rig now
  Play(*rig, 100, 520);
  Finish(*rig, id);
  EXPECT_TRUE(rig->commands().empty());
  EXPECT_EQ(TextOf(id, "refused"), "old epoch");
}

TEST_F(RunChangesTest, RefusesAtOnceWhatTheRigWouldRefuseLater) {
  auto rig = std::make_shared<FakeRig>();
  const std::string id = Begin(rig);
  EXPECT_EQ(manager_->Command(id, kEpoch, Set(paper::kR1, 37.0)).error().field, "value");
  EXPECT_EQ(manager_->Command(id, kEpoch, Set(paper::kJ, 1e-5)).error().field, "component");
  EXPECT_EQ(manager_->Command(id, hardware::Epoch{0}, Set(paper::kR1, 100.0)).error().code,
            core::ErrorCode::kStale);
  Play(*rig, 0, 520);
  Finish(*rig, id);
  EXPECT_TRUE(rig->commands().empty());
}

TEST_F(RunChangesTest, RefusesInARunThatEndsBeforeTheHealthyRigIsLearnt) {
  auto rig = std::make_shared<FakeRig>();
  RunRequest request = Scripted(rig);
  request.plan.uc_v.assign(400, 2.0);
  const auto started = manager_->Start(std::move(request));
  ASSERT_TRUE(started.ok());
  const auto taken = manager_->Command(started.value().id, kEpoch, Set(paper::kR1, 100.0));
  ASSERT_FALSE(taken.ok());
  EXPECT_EQ(taken.error().code, core::ErrorCode::kConflict);
}

TEST_F(RunChangesTest, ARecordingRefusesByItself) {
  std::vector<core::Sample> samples;
  for (int i = 0; i < 100; ++i) samples.push_back(SampleAt(i));
  std::optional<core::Result<Accepted>> answer;
  AtSample tenth(10, [&](const std::string& run, hardware::Epoch epoch) {
    AwaitKnown(run);
    answer = manager_->Command(run, epoch, Set(paper::kR1, 100.0));
  });
  manager_->SetTap(&tenth);
  hardware::ReplayRigOptions options;
  options.bench = &paper::Bench();
  options.speed = 0.0;
  options.queue_messages = 16;
  RunRequest replay;
  replay.diagnosis = paper::Options();
  replay.plan = hardware::ReplayPlan(0.01);
  replay.hold = RigHandle(hardware::MakeReplayRig(samples, options));
  RunToEnd(std::move(replay));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->error().code, core::ErrorCode::kForbidden);
}

TEST(WaitingChanges, AreToldOnceEachInTheirOrder) {
  WaitingChanges waiting(5.0);
  EXPECT_TRUE(waiting.Defer(paper::kR1, 10.0));
  EXPECT_TRUE(waiting.Defer(paper::kR1, 100.0));
  waiting.Drop(paper::kC8);  // nothing waits for it
  EXPECT_EQ(waiting.values(), (WaitingChanges::Values{{paper::kR1, 100.0}}));
  waiting.DropAll();
  const auto notes = waiting.TakeNotes();
  ASSERT_EQ(notes.size(), 3u);
  EXPECT_EQ(notes[1].value, 100.0);
  EXPECT_EQ(notes[2].kind, "change_dropped");
  EXPECT_TRUE(waiting.TakeNotes().empty());
  EXPECT_FALSE(waiting.Next());
  EXPECT_FALSE(waiting.Defer(paper::kR1, 10.0)) << "the stretch is over";
}

TEST(WaitingChanges, HoldNothingWhereNothingIsLearnt) {
  WaitingChanges waiting(std::nullopt);
  EXPECT_FALSE(waiting.Defer(paper::kR1, 10.0));
  EXPECT_TRUE(waiting.TakeNotes().empty());
}

TEST(RunMessages, HelloSaysWhatWaitsAndUntilWhen) {
  const core::PlantParameters nominal = paper::Plant();
  const Positions positions = NominalPositions(paper::Bench(), nominal);
  const std::vector<RecordedEvent> none;
  HelloParts parts{"run-1",
                   "paper-1",
                   RunState::kRunning,
                   kEpoch,
                   100.0,
                   "{}",
                   positions,
                   none,
                   "null",
                   "{}",
                   5.0,
                   {{paper::kR1, 100.0}},
                   nominal,
                   0.0095};
  const auto hello = boost::json::parse("{" + HelloMembers(parts) + "}").as_object();
  EXPECT_EQ(hello.at("learning_until_s").to_number<double>(), 5.0);
  EXPECT_EQ(hello.at("waiting").at("R1").to_number<double>(), 100.0);
  EXPECT_EQ(hello.at("positions").at("R1").at("value").to_number<double>(), 1.0);
  parts.learning_until_s.reset();
  parts.waiting.clear();
  const auto later = boost::json::parse("{" + HelloMembers(parts) + "}").as_object();
  EXPECT_TRUE(later.at("learning_until_s").is_null());
  EXPECT_TRUE(later.at("waiting").as_object().empty());
}

}  // namespace
}  // namespace faultlab::server
