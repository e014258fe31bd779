#include "server/run/run_manager.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cmath>

#include "server/run/recorder.h"
#include "server/run/run_messages.h"
#include "tests/paper_bench.h"
#include "tests/server/run/run_fixture.h"
#include "tests/support/await.h"

namespace faultlab::server {
namespace {

using tests::FakeRig;
using tests::RunFixture;

class RunManagerTest : public RunFixture {};

TEST_F(RunManagerTest, RecordsThePapersExperimentAndNamesTheFault) {
  const RunRecord record = RunToEnd(Paper());
  EXPECT_EQ(record.state, RunState::kFinished) << log_;
  EXPECT_EQ(record.samples, 2000);
  EXPECT_EQ(record.verdict, "fault");
  EXPECT_EQ(record.rig, "sim-1");
  const auto diagnosis = boost::json::parse(record.diagnosis_json).as_object();
  EXPECT_EQ(diagnosis.at("candidates").at(0).at("component"), "R1");
  EXPECT_NEAR(diagnosis.at("candidates").at(0).at("value").to_number<double>(), 100.0, 5.0);
  EXPECT_EQ(diagnosis.at("samples"), 2000);
  for (const char* kind :
       {"started", "fault_commanded", "relay_confirmed", "detected", "isolated", "finished"}) {
    EXPECT_TRUE(Happened(record.id, kind)) << kind;
  }
  const auto events = store_->LoadEvents(record.id).value();
  for (const RecordedEvent& event : events) {
    if (event.kind == "detected") {
      EXPECT_GE(event.index, 1000);
      EXPECT_LE(event.index, 1010) << "within 10 samples of the fault";
    }
  }
}

TEST_F(RunManagerTest, TellsTheMomentsOfFaultDetectionAndEnd) {
  RunToEnd(Paper());
  const auto told = moments();
  ASSERT_EQ(told.size(), 3u);
  EXPECT_EQ(told[0], "fault@1000");
  EXPECT_TRUE(told[1].starts_with("detection@10")) << told[1];
  EXPECT_EQ(told[2], "end@1999");
}

TEST_F(RunManagerTest, TellsNoMomentOfAFaultThatIsHeardOfLateOrOfAReturnToNominal) {
  Manage(1.0);
  auto rig = std::make_shared<FakeRig>();
  auto started = manager_->Start(Scripted(rig));
  ASSERT_TRUE(started.ok());
  const auto confirm = [&](std::int64_t index, double r1_ohm) {
    hardware::RigEvent event;
    event.kind = hardware::RigEventKind::kRelayConfirmed;
    event.index = index;
    event.component = paper::kR1;
    event.value = r1_ohm;
    rig->Say(event);
  };
  clock_.Advance(std::chrono::seconds(60));
  confirm(100, 100.0);   // 59 s ago
  confirm(5900, 100.0);  // 1 s ago
  confirm(5950, 1.0);
  rig->Say(SampleAt(5960));
  hardware::RigEvent finished;
  finished.kind = hardware::RigEventKind::kFinished;
  rig->Say(finished);
  rig->End();
  manager_->Wait(started.value().id);
  EXPECT_EQ(moments(), (std::vector<std::string>{"fault@5900", "end@5960"}));
}

TEST_F(RunManagerTest, GivesTheSameSamplesAndVerdictsForTheSameSeed) {
  const RunRecord first = RunToEnd(Paper());
  const RunRecord second = RunToEnd(Paper());
  const auto a = store_->LoadSamples(first.id, 0, 5000).value();
  const auto b = store_->LoadSamples(second.id, 0, 5000).value();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_EQ(a[i].um_v, b[i].um_v) << i;
  EXPECT_EQ(first.diagnosis_json, second.diagnosis_json);
  EXPECT_EQ(Kinds(first.id), Kinds(second.id));
}

TEST_F(RunManagerTest, LearnsARigFromNoRunWithHiddenFaultsNorWithOneInTheHealthyStretch) {
  RunToEnd(Paper(8.0));
  EXPECT_EQ(calibrated(), 1u);
  RunRequest hidden = Paper(8.0);
  hidden.hidden_faults = true;
  RunToEnd(std::move(hidden));
  EXPECT_EQ(calibrated(), 1u);
  RunRequest early = Paper(8.0);
  early.plan.faults = {{paper::kRa, 7.55, 0.1, core::FaultKind::kAbrupt, 0.0}};
  RunToEnd(std::move(early));
  EXPECT_EQ(calibrated(), 1u);
}

TEST_F(RunManagerTest, StoresAStoppedRunWhole) {
  auto rig = std::make_shared<FakeRig>();
  auto started = manager_->Start(Scripted(rig));
  ASSERT_TRUE(started.ok());
  for (int i = 0; i < 150; ++i) rig->Say(SampleAt(i));
  EXPECT_TRUE(manager_->Stop(started.value().id, "enough").ok());
  manager_->Wait(started.value().id);
  const RunRecord record = store_->Get(started.value().id).value();
  EXPECT_EQ(record.state, RunState::kStopped);
  EXPECT_EQ(record.samples, 150);
  EXPECT_EQ(rig->stops().front(), "enough");
  EXPECT_FALSE(manager_->Stop(started.value().id, "again").ok());
}

TEST_F(RunManagerTest, SaysWhenItsRigFallsSilentAndWhenItIsHeardAgain) {
  auto rig = std::make_shared<FakeRig>();
  auto started = manager_->Start(Scripted(rig));
  ASSERT_TRUE(started.ok());
  const std::string id = started.value().id;
  const auto await = [&](const std::string& kind) {
    RecordedEvent found;
    EXPECT_TRUE(tests::Await([&] {
      const RunSnapshot now = manager_->Find(id).value();
      for (const RecordedEvent& event : now.events) {
        if (event.kind != kind) continue;
        found = event;
        return true;
      }
      clock_.Advance(std::chrono::milliseconds(200));
      return false;
    })) << kind;
    return found;
  };
  for (int i = 0; i < 150; ++i) rig->Say(SampleAt(i));
  rig->FallSilentFor(std::chrono::milliseconds(2001));
  EXPECT_EQ(await("rig_silent").index, 150);
  rig->FallSilentFor(std::chrono::milliseconds(0));
  EXPECT_THAT(await("rig_heard").json, testing::HasSubstr("\"value\":2.001"));
  rig->End();
  manager_->Wait(id);
  const auto kinds = Kinds(id);
  EXPECT_EQ(std::count(kinds.begin(), kinds.end(), "rig_silent"), 1);
}

TEST_F(RunManagerTest, GivesALeaseThatAnotherLabHasAReason) {
  auto rig = std::make_shared<FakeRig>();
  rig->arm_answer_ = core::Error{
      core::ErrorCode::kBusy, "the rig is held by x/y", std::string(hardware::kLeaseField)};
  EXPECT_EQ(manager_->Start(Scripted(rig)).error().reason, "held_elsewhere");
}

TEST_F(RunManagerTest, FailsTheRunOfATrippedRigAndKeepsItsSamples) {
  auto rig = std::make_shared<FakeRig>();
  auto started = manager_->Start(Scripted(rig));
  ASSERT_TRUE(started.ok());
  for (int i = 0; i < 20; ++i) rig->Say(SampleAt(i));
  hardware::RigEvent trip;
  trip.kind = hardware::RigEventKind::kTrip;
  trip.index = 19;
  trip.value = 2.5;
  trip.text = "over-current";
  rig->Say(trip);
  manager_->Wait(started.value().id);
  const RunRecord record = store_->Get(started.value().id).value();
  EXPECT_EQ(record.state, RunState::kFailed);
  EXPECT_EQ(record.samples, 20);
  EXPECT_TRUE(Happened(record.id, "trip"));
  EXPECT_FALSE(rig->stops().empty());
}

TEST_F(RunManagerTest, MakesTheRigSafeWhenItsOwnCodeBreaks) {
  auto rig = std::make_shared<FakeRig>();
  auto started = manager_->Start(Scripted(rig));
  ASSERT_TRUE(started.ok());
  rig->BreakRead();
  manager_->Wait(started.value().id);
  EXPECT_EQ(store_->Get(started.value().id).value().state, RunState::kFailed);
  EXPECT_FALSE(rig->stops().empty());
  EXPECT_NE(log_.find("the rig's code is broken"), std::string::npos);
}

TEST_F(RunManagerTest, FailsTheRunWhenTheRecordingCannotBeWritten) {
  auto rig = std::make_shared<FakeRig>();
  auto started = manager_->Start(Scripted(rig));
  ASSERT_TRUE(started.ok());
  // The recording is finished without the run's knowledge: the store refuses every further chunk.
  ASSERT_TRUE(store_->Finish(started.value().id, RunState::kFailed, clock_.Wall(), "", "").ok());
  for (int i = 0; i < 150; ++i) rig->Say(SampleAt(i));
  for (int i = 150; i < 300; ++i) rig->Say(SampleAt(i));
  rig->End();
  manager_->Wait(started.value().id);
  EXPECT_NE(log_.find("fails"), std::string::npos) << log_;
  EXPECT_FALSE(rig->stops().empty());
}

TEST_F(RunManagerTest, RefusesAPlanThatTheRigRefusesAndGivesTheRigBack) {
  RunRequest request = Paper(5.0);
  request.plan.uc_v[100] = 9.0;
  const auto refused = manager_->Start(std::move(request));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, core::ErrorCode::kInvalid);
  EXPECT_TRUE(manager_->Start(Paper(1.0)).ok());
}

TEST_F(RunManagerTest, AnEndedRunGivesItsPlaceBackThoughNobodyAsksForIt) {
  RunRequest request = Paper(1.0);
  request.place = std::make_shared<int>(1);
  const std::weak_ptr<void> place = request.place;
  const auto run = manager_->Start(std::move(request));
  ASSERT_TRUE(run.ok());
  manager_->Wait(run.value().id);
  EXPECT_TRUE(place.expired());
}

TEST_F(RunManagerTest, ARunWhoseLeaseEndsIsStoppedAndLetsGoBeforeItIsStored) {
  hardware::SimulatedRigOptions options;
  options.id = "bench-1";
  options.kind = hardware::RigKind::kBench;
  rig_pool_.AddResident(hardware::MakeSimulatedRig(options), "bench");
  Manage(1.0);
  RunRequest request = Paper();
  request.hold = Hold("bench-1");
  const auto started = manager_->Start(std::move(request));
  ASSERT_TRUE(started.ok()) << started.error().message;
  const RigHandle next = Hold("bench-1");  // a newer lease: stops the run and waits for its rig
  EXPECT_EQ(next.epoch(), hardware::Epoch{epoch_}) << "and has it";
  manager_->Wait(started.value().id);
  const RunRecord record = store_->Get(started.value().id).value();
  EXPECT_EQ(record.state, RunState::kStopped) << log_;
  EXPECT_FALSE(manager_->Command(record.id, started.value().epoch, {}).ok());
}

TEST_F(RunManagerTest, ALeaseThatEndsBetweenItsHoldAndTheStartStartsNothing) {
  RunRequest request = Paper(1.0);
  rig_pool_.Fence("sim-1", ++epoch_);
  const auto refused = manager_->Start(std::move(request));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, core::ErrorCode::kStale);
  EXPECT_TRUE(manager_->Running().empty());
}

TEST_F(RunManagerTest, StopsEveryRunWhenTheServerStops) {
  auto rig = std::make_shared<FakeRig>();
  auto started = manager_->Start(Scripted(rig));
  ASSERT_TRUE(started.ok());
  manager_->Shutdown();
  EXPECT_EQ(store_->Get(started.value().id).value().state, RunState::kStopped);
  EXPECT_FALSE(manager_->Start(Paper(1.0)).ok());
}

TEST_F(RunManagerTest, LetsCommandsOfTheEpochThroughToTheRig) {
  auto rig = std::make_shared<FakeRig>();
  RunRequest request = Scripted(rig);
  request.diagnosis.calibration = Learnt();  // already calibrated: no change waits
  auto started = manager_->Start(std::move(request));
  ASSERT_TRUE(started.ok());
  const std::string id = started.value().id;
  hardware::RigCommand command;
  command.kind = hardware::RigCommand::Kind::kSetComponent;
  command.component = paper::kR1;
  command.value = 56.0;
  EXPECT_TRUE(manager_->Command(id, hardware::Epoch{1}, command).ok());
  EXPECT_EQ(manager_->Command(id, hardware::Epoch{0}, command).error().code,
            core::ErrorCode::kStale);
  ASSERT_EQ(rig->commands().size(), 1u);
  EXPECT_EQ(rig->commands()[0].value, 56.0);
}

TEST(Recorder, KeepsEverythingOrSaysThatItCannot) {
  tests::TempFolder folder;
  DatabaseOptions options;
  options.location = folder.File("r.db");
  auto database = std::move(Database::Open(options)).value();
  RecordingStore store(*database);
  RunRecord record;
  record.id = "run-a";
  ASSERT_TRUE(store.Begin(record).ok());
  Recorder recorder(store, "", {}, [](std::string_view) {});
  for (std::int64_t i = 0; i < 200; ++i) {
    core::Sample sample;
    sample.index = i;
    ASSERT_TRUE(
        recorder.Append("run-a", std::vector<core::Sample>{sample}, Recorder::WhenFull::kWait));
  }
  EXPECT_TRUE(recorder.Drain("run-a", {}).ok());
  EXPECT_EQ(store.LoadSamples("run-a", 0, 1000).value().size(), 200u);
  recorder.Append("run-unknown", std::vector<core::Sample>(1), Recorder::WhenFull::kWait);
  EXPECT_FALSE(recorder.Drain("run-unknown", {}).ok());
}

TEST(RunMessages, EventsComeBackFromARecording) {
  hardware::RigEvent event;
  event.kind = hardware::RigEventKind::kRelayConfirmed;
  event.index = 1000;
  event.component = paper::kC8;
  event.value = 1e-6;
  const RecordedEvent recorded = MakeEvent(event, 0.01);
  EXPECT_EQ(recorded.kind, "relay_confirmed");
  const auto json = boost::json::parse(recorded.json).as_object();
  EXPECT_EQ(json.at("t_s").to_number<double>(), 10.0);
  const auto back = ToRigEvent(recorded, paper::Bench());
  ASSERT_TRUE(back);
  EXPECT_EQ(back->index, 1000);
  EXPECT_EQ(back->component, paper::kC8);
  EXPECT_EQ(back->value, 1e-6);
  EXPECT_FALSE(ToRigEvent(MakeDiagnosisEvent("detected", 5, 0.01, "glr"), paper::Bench()));
}

TEST(RunMessages, PositionsFollowTheRigAndNotTheWish) {
  const Positions nominal = NominalPositions(paper::Bench(), paper::Plant());
  Positions positions = nominal;
  hardware::RigEvent event;
  event.component = paper::kR1;
  event.value = 100.0;
  event.kind = hardware::RigEventKind::kFaultCommanded;
  Follow(positions, event, nominal);
  EXPECT_EQ(positions[paper::kR1].value, 1.0);
  EXPECT_EQ(positions[paper::kR1].state, "commanded");
  event.kind = hardware::RigEventKind::kRelayConfirmed;
  Follow(positions, event, nominal);
  EXPECT_EQ(positions[paper::kR1].value, 100.0);
  EXPECT_EQ(positions[paper::kR1].state, "confirmed");
  event.kind = hardware::RigEventKind::kStopped;
  Follow(positions, event, nominal);
  EXPECT_EQ(positions[paper::kR1].value, 1.0);
}

TEST(RunMessages, ReadoutHasNullsForWhatIsNotKnown) {
  core::Frame frame;
  frame.sample.index = 12;
  frame.estimates[1].status = core::EstimateStatus::kNotExcited;
  frame.estimates[1].theta = {1.0, 2.0, 3.0};
  frame.estimates[1].sigma = {std::nan(""), std::nan(""), std::nan("")};
  frame.estimates[1].age_samples = 40;
  const auto json = boost::json::parse(ReadoutText(frame)).as_object();
  EXPECT_EQ(json.at("index"), 12);
  EXPECT_TRUE(json.at("estimators").at(0).at("theta").is_null());
  EXPECT_EQ(json.at("estimators").at(1).at("theta").at(2).to_number<double>(), 3.0);
  EXPECT_TRUE(json.at("estimators").at(1).at("sigma").at(0).is_null());
  EXPECT_EQ(json.at("estimators").at(1).at("age"), 40);
}

}  // namespace
}  // namespace faultlab::server
