#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "hardware/lcm/channels.h"
#include "hardware/lcm/remote_rig.h"
#include "hardware/lcm/rig_agent.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/hardware/lossy_bus.h"

namespace faultlab::hardware {

/// Time that passes `speed` times faster than the machine's.
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

/// An agent with a simulated bench in a thread of its own.
class AgentThread {
 public:
  AgentThread(LossyBus& bus, double speed, RigAgentSettings settings, std::string id = "far-1")
      : bus_(bus.MakeEnd()) {
    SimulatedRigOptions options;
    options.id = std::move(id);
    options.speed = speed;
    options.queue_messages = 1u << 16;
    rig_ = MakeSimulatedRig(options);
    settings.key = TestKey();
    agent_ = std::make_unique<RigAgent>(*rig_, *bus_, settings, FastTime(speed), UnixNs);
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
  /// Only when the thread has ended, or for what does not change.
  RigAgent& agent() { return *agent_; }

 private:
  std::unique_ptr<MessageBus> bus_;
  std::unique_ptr<Rig> rig_;
  std::unique_ptr<RigAgent> agent_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A server that knows one far rig.
class ServerThread {
 public:
  ServerThread(LossyBus& bus, double speed, std::string holder, std::string id = "far-1")
      : bus_(bus.MakeEnd()),
        rig_(std::make_shared<RemoteRig>(
            id,
            bus_,
            RemoteRigSettings{
                .holder = std::move(holder), .key = TestKey(), .give_up = std::chrono::seconds(20)},
            FastTime(speed),
            UnixNs)) {
    bus_->Subscribe("FAULTLAB\\.ANNOUNCE", [this](const std::string&, MessageBus::Bytes bytes) {
      rig_->OnAnnounce(bytes);
    });
    bus_->Subscribe("FAULTLAB\\." + id + "\\.REPLY",
                    [this](const std::string&, MessageBus::Bytes bytes) { rig_->OnReply(bytes); });
    bus_->Subscribe("FAULTLAB\\." + id + "\\.STREAM",
                    [this](const std::string&, MessageBus::Bytes bytes) { rig_->OnStream(bytes); });
    thread_ = std::thread([this] {
      while (!stop_) {
        bus_->Handle(std::chrono::milliseconds(1));
        rig_->Poll();
      }
    });
  }
  /// As if killed: no goodbye.
  ~ServerThread() {
    stop_ = true;
    thread_.join();
  }

  RemoteRig& rig() { return *rig_; }
  void WaitUntilHeard() {
    while (rig_->info().link != LinkState::kBack) std::this_thread::yield();
  }

 private:
  std::shared_ptr<MessageBus> bus_;
  std::shared_ptr<RemoteRig> rig_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace faultlab::hardware
