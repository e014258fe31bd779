// A run whose faults are known to its witness alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "server/net/http_server.h"
#include "server/net/router.h"
#include "tests/server/run/run_fixture.h"
#include "tests/support/raw_client.h"

namespace faultlab::tests {
namespace {

class Witness final : public SealedWitness {
 public:
  void OnEvent(const hardware::RigEvent& event, double /*period_s*/) override {
    events.push_back(event);
  }
  void OnEnd(const SealedEnd& how) override { end = how; }
  std::vector<hardware::RigEvent> events;
  SealedEnd end{};
};

class SealedRunTest : public RunFixture {
 protected:
  SealedRunTest() {
    HttpServerOptions http;
    http.listen = "127.0.0.1:0";
    server_ = std::make_unique<HttpServer>(
        http, router_, [this](const HttpRequest& request) -> UpgradeDecision {
          const std::string run = request.Query("run").value_or("");
          return [this, run](UpgradedSocket socket) {
            hub_->Adopt(std::move(socket), run, {.caller = "user:1", .account_id = 1}, true);
          };
        });
    EXPECT_TRUE(server_->Start().ok());
  }
  ~SealedRunTest() override { server_->Stop(); }

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
    const std::string id = started.value().id;
    tests::WebSocketClient page(server_->port(), "/ws?run=" + id);
    frames_ = page.ReadTextWith("\"hello\"").value_or("");
    EXPECT_FALSE(frames_.empty());
    rig->AwaitSilentReads(2);  // a rig may take its time before it says anything
    rig->Say(SampleAt(0));
    frames_ += page.ReadTextWith("\"readout\"").value_or("");  // the only one: the clock stands
    for (std::int64_t k = 1; k < 300; ++k) {
      for (const hardware::RigEvent& event : hidden) {
        if (event.index == k) rig->Say(event);
      }
      rig->Say(SampleAt(k));
    }
    rig->Say(hardware::RigEvent{hardware::RigEventKind::kFinished, 300, {}, 0.0, ""});
    rig->End();
    manager_->Wait(id);
    while (const auto frame = page.Read()) {
      frames_ += frame->payload + "\n";
      if (frame->payload.find(R"("type":"end")") != std::string::npos) break;
    }
    for (std::size_t at = 0; (at = frames_.find(id)) != std::string::npos;) {
      frames_.replace(at, id.size(), "RUN");
    }
    return Told(id);
  }

  Router router_;
  std::unique_ptr<HttpServer> server_;
  std::string frames_;  ///< every byte that the page of its student got, but for the run's name
};

TEST_F(SealedRunTest, IdenticalSamplesUnderTwoTruthsAreToldAlike) {
  using enum hardware::RigEventKind;
  const auto one = std::make_shared<Witness>();
  const auto two = std::make_shared<Witness>();
  const std::string first = Played(
      {{kFaultCommanded, 101, paper::kR1, 56.0, ""}, {kRelayConfirmed, 103, paper::kR1, 56.0, ""}},
      one);
  const std::string frames = frames_;
  const std::string second = Played({{kRefused, 207, paper::kRa, 9.0, "no relay has it"}}, two);
  EXPECT_EQ(first, second);
  EXPECT_GT(frames.size(), 300U * 4U) << "samples are among them";
  const std::size_t differs = std::ranges::mismatch(frames, frames_).in1 - frames.begin();
  EXPECT_TRUE(frames == frames_) << "from byte " << differs << " of " << frames.size() << ": "
                                 << frames.substr(differs - std::min<std::size_t>(differs, 60), 120)
                                 << " and "
                                 << frames_.substr(differs - std::min<std::size_t>(differs, 60),
                                                   120);
  EXPECT_EQ(first.find("fault_commanded"), std::string::npos);
  ASSERT_EQ(one->events.size(), 2U);
  EXPECT_EQ(one->events[1].index, 103);
  EXPECT_EQ(two->events.size(), 1U);
  EXPECT_EQ(one->end.state, RunState::kFinished);
  EXPECT_DOUBLE_EQ(one->end.length_s, 3.0);
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

TEST_F(SealedRunTest, TellsItsWitnessWhoStoppedIt) {
  // A rig that plays until it is stopped: no stop comes too late.
  const auto stopped = [this](RigHandle hold, const std::function<void(const std::string&)>& stop) {
    const auto witness = std::make_shared<Witness>();
    RunRequest request = Scripted(std::make_shared<FakeRig>());
    request.hold = std::move(hold);
    request.witness = witness;
    const auto started = manager_->Start(std::move(request));
    EXPECT_TRUE(started.ok()) << started.error().message;
    stop(started.value().id);
    manager_->Wait(started.value().id);
    EXPECT_EQ(witness->end.state, RunState::kStopped);
    return witness->end;
  };
  const auto by = [&](std::string_view reason) {
    return stopped(RigHandle(std::make_shared<FakeRig>()), [this, reason](const auto& id) {
      EXPECT_TRUE(manager_->Stop(id, reason).ok());
    });
  };
  EXPECT_TRUE(by(kStoppedByOwner).by_owner);
  const SealedEnd by_another = by(kStoppedByAnother);
  EXPECT_FALSE(by_another.by_owner);
  EXPECT_TRUE(by_another.by_another);
  const SealedEnd by_server = by("the server stops");
  EXPECT_FALSE(by_server.by_owner || by_server.by_another);
  EXPECT_EQ(by_server.revoked, lab::SessionId{});
  const auto rig = std::make_shared<FakeRig>();
  rig_pool_.AddResident(rig, "bench");
  const SealedEnd by_lab = stopped(Hold("fake-1"), [&](const auto&) {
    rig_pool_.Fence("fake-1", ++epoch_);
    rig->SafeStop("the lease was revoked");  // as a rig does when it is fenced
  });
  EXPECT_FALSE(by_lab.by_owner || by_lab.by_another);
  EXPECT_EQ(by_lab.revoked, lab::SessionId{7});
}

}  // namespace
}  // namespace faultlab::tests
