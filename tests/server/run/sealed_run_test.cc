// A run whose faults are known to its witness alone.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/server/run/run_fixture.h"

namespace faultlab::tests {
namespace {

class Witness final : public SealedWitness {
 public:
  void OnEvent(const hardware::RigEvent& event, double /*period_s*/) override {
    events.push_back(event);
  }
  void OnEnd(RunState state, bool tripped_now, double length) override {
    end = state;
    tripped = tripped_now;
    length_s = length;
  }
  std::vector<hardware::RigEvent> events;
  RunState end = RunState::kRunning;
  bool tripped = false;
  double length_s = 0.0;
};

class SealedRunTest : public RunFixture {
 protected:
  /// Everything of a run that people are shown or that is stored, without its id.
  std::string Told(const std::string& id) {
    const RunRecord record = store_->Get(id).value();
    std::string all = record.plan_json + record.options_json + record.diagnosis_json +
                      record.verdict + std::string(Name(record.state));
    const auto events = store_->LoadEvents(id);
    for (const RecordedEvent& event : events.value()) all += event.json;
    const RunCounters counters = manager_->counters();
    all += " tasks " + std::to_string(counters.solver_tasks);
    if (const auto live = manager_->Find(id)) {
      all += live->verdict + live->diagnosis_json;
      for (const RecordedEvent& event : live->events) all += event.json;
    }
    return all + " " + std::to_string(store_->LoadSamples(id).value().size());
  }
  std::string Played(const std::vector<hardware::RigEvent>& hidden,
                     const std::shared_ptr<Witness>& witness) {
    const auto rig = std::make_shared<FakeRig>();
    RunRequest request = Scripted(rig);
    request.plan_json = R"({"sealed":true})";
    request.diagnosis.healthy_from_s = request.diagnosis.healthy_to_s = 1e9;
    request.witness = witness;
    const auto started = manager_->Start(std::move(request));
    EXPECT_TRUE(started.ok());
    for (std::int64_t k = 0; k < 300; ++k) {
      for (const hardware::RigEvent& event : hidden) {
        if (event.index == k) rig->Say(event);
      }
      rig->Say(SampleAt(k));
    }
    rig->Say(hardware::RigEvent{hardware::RigEventKind::kFinished, 300, {}, 0.0, ""});
    rig->End();
    manager_->Wait(started.value().id);
    return Told(started.value().id);
  }
};

TEST_F(SealedRunTest, IdenticalSamplesUnderTwoTruthsAreToldAlike) {
  using enum hardware::RigEventKind;
  const auto one = std::make_shared<Witness>();
  const auto two = std::make_shared<Witness>();
  const std::string first = Played(
      {{kFaultCommanded, 101, paper::kR1, 56.0, ""}, {kRelayConfirmed, 103, paper::kR1, 56.0, ""}},
      one);
  const std::string second = Played({{kRefused, 207, paper::kRa, 9.0, "no relay has it"}}, two);
  EXPECT_EQ(first, second);
  EXPECT_EQ(first.find("fault_commanded"), std::string::npos);
  ASSERT_EQ(one->events.size(), 2U);
  EXPECT_EQ(one->events[1].index, 103);
  EXPECT_EQ(two->events.size(), 1U);
  EXPECT_EQ(one->end, RunState::kFinished);
  EXPECT_DOUBLE_EQ(one->length_s, 3.0);
}

TEST_F(SealedRunTest, TakesNoCommandAndLearnsNothing) {
  const auto witness = std::make_shared<Witness>();
  RunRequest request = Paper(12.0);
  request.witness = witness;
  request.diagnosis.healthy_from_s = request.diagnosis.healthy_to_s = 1e9;
  const auto started = manager_->Start(std::move(request));
  ASSERT_TRUE(started.ok()) << started.error().message;
  const std::string id = started.value().id;
  const hardware::RigCommand change{hardware::RigCommand::Kind::kSetComponent, paper::kR1, 56.0};
  const auto taken = manager_->Command(id, started.value().epoch, change);
  ASSERT_FALSE(taken.ok());
  EXPECT_TRUE(taken.error().reason == "run_sealed" || taken.error().reason == "run_ended");
  EXPECT_FALSE(manager_->LearnAgain(id).ok());
  manager_->Wait(id);
  EXPECT_EQ(calibrated(), 0U);
  EXPECT_EQ(manager_->counters().solver_tasks, 0U);
  EXPECT_EQ(store_->Get(id).value().verdict, "calibrating");
  EXPECT_EQ(moments(), (std::vector<std::string>{"end@1199"})) << "no picture at the fault";
  EXPECT_FALSE(Happened(id, "fault_commanded"));
  ASSERT_EQ(witness->events.size(), 2U);
}

}  // namespace
}  // namespace faultlab::tests
