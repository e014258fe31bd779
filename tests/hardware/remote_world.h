#pragma once

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "core/types/check.h"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/epoch_file.h"
#include "hardware/lcm/remote_rig.h"
#include "hardware/lcm/rig_agent.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/lossy_bus.h"

namespace faultlab::hardware {

/// Time that passes `speed` times as fast as the machine's.
inline std::function<Nanoseconds()> FastTime(double speed) {
  return [speed] {
    return Nanoseconds(static_cast<std::int64_t>(
        speed * static_cast<double>(std::chrono::steady_clock::now().time_since_epoch().count())));
  };
}

inline std::int64_t UnixNs() {
  return std::chrono::system_clock::now().time_since_epoch().count();
}

inline RigKey TestKey() {
  RigKey key;
  key.fill(0x5a);
  return key;
}

/// An agent whose run outlives a silence of `seconds`.
inline RigAgentSettings RidesThrough(int seconds) {
  RigAgentSettings settings;
  settings.watchdog = std::chrono::seconds(seconds);
  settings.lease = std::chrono::seconds(seconds + 5);
  return settings;
}

/// A folder for the epochs of a world's agents. Removed with this object.
class StateFolder {
 public:
  StateFolder() {
    path_ = (std::filesystem::temp_directory_path() / "agent_state_XXXXXX").string();
    LAB_CHECK(mkdtemp(path_.data()) != nullptr, path_);
  }
  ~StateFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  StateFolder(const StateFolder&) = delete;
  StateFolder& operator=(const StateFolder&) = delete;
  const std::string& path() const { return path_; }
  EpochFile Open(const std::string& rig = "far-1") const {
    return EpochFile::Open(path_, rig).value();
  }

 private:
  std::string path_;
};

/// An agent with a simulated bench in a thread of its own.
class AgentThread {
 public:
  /// @param state  for several starts of the same agent; null: for this one alone
  AgentThread(LossyBus& bus,
              double speed,
              RigAgentSettings settings,
              std::string id = "far-1",
              const StateFolder* state = nullptr)
      : bus_(bus.MakeEnd()) {
    SimulatedRigOptions options;
    options.id = std::move(id);
    options.speed = speed;
    options.queue_messages = 1u << 16;
    rig_ = MakeSimulatedRig(options);
    settings.key = TestKey();
    const StateFolder& folder = state != nullptr ? *state : own_state_;
    agent_ = std::make_unique<RigAgent>(
        *rig_, *bus_, settings, folder.Open(rig_->description().id), FastTime(speed), UnixNs);
    thread_ = std::thread([this] {
      while (!stop_) {
        bus_->Handle(std::chrono::milliseconds(1));
        agent_->Poll();
      }
    });
  }
  ~AgentThread() {
    stop_ = true;
    thread_.join();
  }

  Rig& rig() { return *rig_; }
  /// To be called only when the thread has ended, or for what does not change.
  RigAgent& agent() { return *agent_; }

 private:
  const StateFolder own_state_;
  std::unique_ptr<MessageBus> bus_;
  std::unique_ptr<Rig> rig_;
  std::unique_ptr<RigAgent> agent_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A server that knows one remote rig.
class ServerThread {
 public:
  /// @param give_up  time limit of one request, in time of the world
  ServerThread(LossyBus& bus,
               double speed,
               std::string holder,
               Nanoseconds give_up = std::chrono::seconds(200))
      : bus_(bus.MakeEnd()),
        rig_(std::make_shared<RemoteRig>(
            "far-1",
            bus_,
            RemoteRigSettings{.holder = std::move(holder), .key = TestKey(), .give_up = give_up},
            FastTime(speed),
            UnixNs)) {
    bus_->Subscribe("FAULTLAB\\.ANNOUNCE", [this](const std::string&, MessageBus::Bytes bytes) {
      if (is_deaf_to_announcements) return;
      rig_->OnAnnounce(bytes);
      ++announcements_heard;
    });
    bus_->Subscribe("FAULTLAB\\.far-1\\.REPLY",
                    [this](const std::string&, MessageBus::Bytes bytes) { rig_->OnReply(bytes); });
    bus_->Subscribe("FAULTLAB\\.far-1\\.STREAM",
                    [this](const std::string&, MessageBus::Bytes bytes) { rig_->OnStream(bytes); });
    thread_ = std::thread([this] {
      while (!stop_) {
        bus_->Handle(std::chrono::milliseconds(1));
        rig_->Poll();
      }
    });
  }
  /// Ends as if killed: without a last message.
  ~ServerThread() {
    stop_ = true;
    thread_.join();
  }

  std::atomic<bool> is_deaf_to_announcements{false};  ///< they are lost on their way
  std::atomic<int> announcements_heard{0};

  RemoteRig& rig() { return *rig_; }
  const std::shared_ptr<RemoteRig>& shared_rig() const { return rig_; }
  void WaitUntilHeard() {
    while (rig_->info().link != LinkState::kBack) std::this_thread::yield();
  }

 private:
  std::shared_ptr<MessageBus> bus_;
  std::shared_ptr<RemoteRig> rig_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// One server and one agent on a bus, which have heard of each other.
struct FarWorld {
  FarWorld(const Weather& weather,
           std::uint64_t seed,
           double speed,
           const RigAgentSettings& settings = RidesThrough(60),
           std::string holder = "lab/a")
      : bus(weather, seed), agent(bus, speed, settings), server(bus, speed, std::move(holder)) {
    server.WaitUntilHeard();
  }
  RemoteRig& rig() { return server.rig(); }

  LossyBus bus;
  AgentThread agent;
  ServerThread server;
};

}  // namespace faultlab::hardware
