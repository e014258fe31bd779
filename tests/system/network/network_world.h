#pragma once

// Agents and servers on real UDP multicast, in the network namespace of this process
// (private_network.cc).
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "hardware/clock.h"
#include "hardware/lcm/epoch_file.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/rig_agent.h"
#include "hardware/lcm/rig_finder.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/rig_runs.h"
#include "tests/support/await.h"
#include "tests/system/network/lcm_logger.h"

namespace faultlab::hardware {

/// One folder for this process and its child processes.
inline const std::string& KeyFolder() {
  static const std::string folder =
      testing::TempDir() + "/network_keys_" + std::to_string(getpid());
  return folder;
}

/// An agent with a simulated bench on the real bus, in this process, so that its counts can be
/// read.
class AgentHere {
 public:
  AgentHere(const std::string& id, double speed, double ride_through_s)
      : bus_(OpenLcmBus(Url(kAgentPort)).value()) {
    SimulatedRigOptions options;
    options.id = id;
    options.speed = speed;
    options.queue_messages = 1u << 16;
    rig_ = MakeSimulatedRig(options);
    RigAgentSettings settings;
    settings.key = LoadOrMakeRigKey(KeyFolder(), id).value();
    const auto ride = Nanoseconds(static_cast<std::int64_t>(ride_through_s * 1e9));
    settings.watchdog = std::max(settings.watchdog, ride);
    settings.lease += ride;
    agent_ = std::make_unique<RigAgent>(
        *rig_,
        *bus_,
        settings,
        EpochFile::Open(KeyFolder(), id).value(),
        [clock = MakeSteadyClock()] { return clock->Now(); },
        [] { return std::chrono::system_clock::now().time_since_epoch().count(); });
    thread_ = std::thread([this] {
      while (!stop_) {
        bus_->Handle(std::chrono::milliseconds(2));
        agent_->Poll();
      }
    });
  }
  ~AgentHere() { Stop(); }
  /// Ends the thread; then the counts may be read.
  const RigAgentCounts& Stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return agent_->counts();
  }
  Rig& rig() { return *rig_; }

 private:
  std::unique_ptr<MessageBus> bus_;
  std::unique_ptr<Rig> rig_;
  std::unique_ptr<RigAgent> agent_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

inline std::unique_ptr<RigFinder> Finder(int port,
                                         const std::string& name,
                                         const std::string& lab = "") {
  return OpenRigFinder(
             {.lcm_url = Url(port), .key_directory = KeyFolder(), .lab = lab, .server_name = name})
      .value();
}

inline RemoteRigInfo InfoOf(const RigFinder& finder, const std::string& id) {
  for (const RemoteRigInfo& info : finder.List()) {
    if (info.description.id == id) return info;
  }
  return {};
}

inline std::shared_ptr<Rig> WaitFor(RigFinder& finder, const std::string& id) {
  EXPECT_TRUE(tests::Await([&] { return InfoOf(finder, id).link == LinkState::kBack; })) << id;
  return finder.Find(id);
}

inline void ExpectEveryIndex(const RunLog& log, std::size_t samples) {
  ASSERT_EQ(log.samples.size(), samples);
  for (std::size_t k = 0; k < samples; ++k) {
    ASSERT_EQ(log.samples[k].index, static_cast<std::int64_t>(k));
  }
  EXPECT_TRUE(log.Of(RigEventKind::kGap).empty());
}

}  // namespace faultlab::hardware
