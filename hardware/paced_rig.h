#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hardware/bounded_queue.h"
#include "hardware/clock.h"
#include "hardware/heartbeat.h"
#include "hardware/holder_silence.h"
#include "hardware/rig.h"
#include "hardware/rig_machine.h"

namespace faultlab::hardware {

struct PacedRigOptions {
  std::shared_ptr<Clock> clock;  ///< the run's time
  std::shared_ptr<Clock> wall;   ///< time of the watchdog
  /// > 0: the loop's thread asks for SCHED_FIFO; loop_quality() says whether it got it.
  int fifo_priority = 0;
  std::size_t queue_messages = 4096;
  /// A full queue makes the loop wait (simulators) instead of failing the run. Under speed control
  /// it waits for the reader at each sample, whose orders then come at the same samples each time.
  bool wait_for_reader = false;
  Nanoseconds watchdog = kHolderSilence;  ///< 0 = none
  int consecutive_overruns_max = 5;       ///< the run stops at this many late ticks in a row
  std::shared_ptr<Heartbeat> heartbeat = nullptr;  ///< of a rig with a supervisor; null = none
};

/// The paced half of every rig that lives in this process: lease fence, state, queue, watchdog,
/// overruns, and the safe stop on every way out. What is done at each tick is the machine's.
///
///   Arm -> kArmed -> Start -> kRunning -> (end | SafeStop | trip | error) -> kIdle or kTripped
///
/// Whatever ends the loop, the machine is safe before the last message is readable.
class PacedRig final : public Rig {
 public:
  PacedRig(std::unique_ptr<RigMachine> machine, PacedRigOptions options);
  ~PacedRig() override;
  PacedRig(const PacedRig&) = delete;
  PacedRig& operator=(const PacedRig&) = delete;

  const RigDescription& description() const override { return machine_->description(); }
  RigState state() const override;
  core::Status Arm(RunPlan plan, Epoch epoch) override;
  core::Status Start(Epoch epoch) override;
  core::Status Command(Epoch epoch, const RigCommand& command) override;
  void KeepAlive(Epoch epoch) override;
  ReadStatus Read(std::vector<RigMessage>& out, std::chrono::milliseconds patience) override;
  void Fence(Epoch epoch) override;
  void SafeStop(std::string_view reason) override;
  core::Result<SelfTestReport> SelfTest(Epoch epoch) override;
  std::optional<Trip> trip() const override;
  LoopQuality loop_quality() const override;

 private:
  static constexpr std::size_t kCommandsMax = 16;
  static constexpr Nanoseconds kNotAsked{-1};

  std::optional<Nanoseconds> Step(const Wake& wake) noexcept;

  /// Why a run ends, and since when that was so; without a reason it goes on.
  struct Stop {
    std::string reason;
    Nanoseconds cause_at{0};
  };

  core::Status CheckEpoch(Epoch epoch) const;
  void HeardFrom();
  bool HolderIsSilent() const;
  Stop StopOfSilence() const;
  void CountTick(const Wake& wake, std::vector<RigMessage>& out);
  void CountActuation(const std::vector<RigMessage>& said);
  Stop Deliver(std::vector<RigMessage>& messages);
  std::chrono::steady_clock::time_point ReaderDeadline() const;
  Stop FindStop() const;
  void Finish(Stop stop, bool finished);
  void NoteSafe(Nanoseconds cause_at);
  void Latch(Trip trip);

  const std::unique_ptr<RigMachine> machine_;
  const PacedRigOptions options_;
  BoundedQueue<RigMessage> queue_;

  /// Guards the machine: held during each of its calls. Taken before mutex_.
  std::mutex machine_mutex_;

  mutable std::mutex mutex_;
  std::condition_variable state_changed_;
  RigState state_ = RigState::kIdle;
  Epoch epoch_{0};
  std::vector<RigCommand> commands_;
  /// When the newest command for a component came that has not acted yet.
  std::array<Nanoseconds, core::kComponentsMax> asked_at_{};
  std::optional<std::string> stop_reason_;
  std::optional<Nanoseconds> safe_after_;  ///< RigEvent::value of the run's end
  std::optional<Trip> trip_;
  LoopQuality quality_;
  Nanoseconds period_{0};
  bool in_step_ = false;  ///< with the reader, a sample after another

  std::atomic<std::int64_t> heard_at_ns_{0};
  std::atomic<int> readers_{0};
  std::atomic<bool> stop_asked_{false};
  std::atomic<bool> fifo_{false};

  // Of the loop alone.
  Nanoseconds started_at_{0};
  Nanoseconds planned_{0};
  Nanoseconds shift_{0};
  std::int64_t next_index_ = 0;
  int consecutive_overruns_ = 0;
  bool first_step_ = true;
  std::vector<RigMessage> messages_;
  std::vector<RigCommand> taken_;

  std::jthread loop_;  ///< last: its end needs all of the above
};

}  // namespace faultlab::hardware
