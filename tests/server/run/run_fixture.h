#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/signals/excitation.h"
#include "hardware/simulated/simulated_rig.h"
#include "server/run/run_manager.h"
#include "server/storage/database.h"
#include "tests/paper_rig.h"
#include "tests/server/run/fake_rig.h"
#include "tests/support/temp_folder.h"

namespace faultlab::tests {

using namespace server;  // NOLINT(google-build-using-namespace)

/// A run manager over a simulated rig, with a store and a hub of its own.
class RunFixture : public ::testing::Test {
 protected:
  RunFixture() {
    DatabaseOptions options;
    options.location = folder_.File("test.db");
    database_ = std::move(Database::Open(options)).value();
    store_ = std::make_unique<RecordingStore>(*database_);
    hub_ = std::make_unique<StreamHub>(StreamHubOptions{}, clock_);
    EXPECT_TRUE(hub_->Start().ok());
    hardware::SimulatedRigOptions simulator;
    simulator.speed = 0.0;
    simulator.queue_messages = 16;  // the rig is never far ahead of its run
    rig_pool_.Add(hardware::MakeSimulatedRig(simulator)->description(), "bench", [simulator] {
      return std::shared_ptr<hardware::Rig>(hardware::MakeSimulatedRig(simulator));
    });
    Manage(0.0);
  }

  void Manage(double speed) {
    RunManagerOptions options;
    options.speed = speed;
    options.backlog_folder = folder_.File("backlog");
    options.leave_after = leave_after_;
    options.calibrated = [this](const LearntRig& learnt) {
      const std::lock_guard lock(told_mutex_);
      calibrated_.push_back(learnt.run);
    };
    options.moment = [this](const RunMoment& moment) {
      const std::lock_guard lock(told_mutex_);
      moments_.push_back(std::string(moment.why) + "@" + std::to_string(moment.index));
    };
    manager_ = std::make_unique<RunManager>(
        options, *store_, *hub_, clock_, [this](std::string_view text) {
          const std::lock_guard lock(told_mutex_);
          log_.append(text).append("\n");
        });
  }

  /// Number of runs that gave a calibration of their rig.
  std::size_t calibrated() {
    const std::lock_guard lock(told_mutex_);
    return calibrated_.size();
  }

  /// What pictures would be taken of: "fault@1000".
  std::vector<std::string> moments() {
    const std::lock_guard lock(told_mutex_);
    return moments_;
  }

  /// The paper's experiment, R1 = 100 ohm at 10 s.
  RunRequest Paper(double duration_s = 20.0) {
    RunRequest request;
    request.diagnosis = paper::Options();
    request.owner = "guest";
    request.hold = Hold("sim-1");
    request.plan.uc_v = core::Generate(core::PrbsSpec{}, duration_s, 0.01).value();
    if (duration_s > 10.0) {
      request.plan.faults = {{paper::kR1, 100.0, 10.0, core::FaultKind::kAbrupt, 0.0}};
    }
    return request;
  }
  /// The rig under the next lease of its epoch; an empty hold if the pool refuses it.
  RigHandle Hold(const std::string& rig) {
    auto hold = rig_pool_.Acquire({.rig = rig, .session = lab::SessionId{7}, .epoch = ++epoch_});
    return hold ? std::move(hold).value() : RigHandle{};
  }
  /// A run on a rig that returns the messages given by the test.
  RunRequest Scripted(const std::shared_ptr<FakeRig>& rig) {
    RunRequest request;
    request.diagnosis = paper::Options();
    request.owner = "guest";
    request.plan.uc_v.assign(1000, 2.0);
    request.hold = RigHandle(rig);
    return request;
  }
  static core::Sample SampleAt(std::int64_t index) {
    core::Sample sample;
    sample.index = index;
    sample.t_s = static_cast<double>(index) * 0.01;
    sample.uc_v = 2.0;
    sample.um_v = 4.8;
    return sample;
  }
  RunRecord RunToEnd(RunRequest request) {
    auto started = manager_->Start(std::move(request));
    EXPECT_TRUE(started.ok()) << started.error().message;
    manager_->Wait(started.value().id);
    return store_->Get(started.value().id).value();
  }
  /// The calibration from a run on the simulated rig.
  core::Calibration Learnt() {
    const auto samples = store_->LoadSamples(RunToEnd(Paper(6.0)).id, 50, 500).value();
    return core::Calibrate(samples, paper::ToCalibrate()).value();
  }
  std::vector<std::string> Kinds(const std::string& id) {
    std::vector<std::string> kinds;
    const auto events = store_->LoadEvents(id);
    for (const RecordedEvent& event : events.value()) kinds.push_back(event.kind);
    return kinds;
  }
  bool Happened(const std::string& id, std::string_view kind) {
    const auto kinds = Kinds(id);
    return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
  }

  tests::TempFolder folder_;
  ManualClock clock_;
  std::unique_ptr<Database> database_;
  std::unique_ptr<RecordingStore> store_;
  std::unique_ptr<StreamHub> hub_;
  RigPool rig_pool_;
  std::uint64_t epoch_ = 0;
  std::chrono::milliseconds leave_after_{5000};
  std::string log_;
  std::mutex told_mutex_;
  std::vector<std::string> calibrated_;
  std::vector<std::string> moments_;
  std::unique_ptr<RunManager> manager_;
};

}  // namespace faultlab::tests
