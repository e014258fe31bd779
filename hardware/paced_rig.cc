#include "hardware/paced_rig.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "core/types/check.h"
#include "hardware/refusal.h"
#include "hardware/run_loop.h"

namespace faultlab::hardware {
namespace {

core::Error Conflict(std::string message) {
  return {.code = core::ErrorCode::kConflict, .message = std::move(message), .field = {}};
}

}  // namespace

PacedRig::PacedRig(std::unique_ptr<RigMachine> machine, PacedRigOptions options)
    : machine_(std::move(machine)), options_(std::move(options)), queue_(options_.queue_messages) {
  LAB_CHECK(machine_ && options_.clock && options_.wall);
  LAB_CHECK(options_.queue_messages >= 1);
}

PacedRig::~PacedRig() {
  SafeStop("the rig was closed");
}

RigState PacedRig::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

std::optional<Trip> PacedRig::trip() const {
  const std::lock_guard lock(mutex_);
  return trip_;
}

LoopQuality PacedRig::loop_quality() const {
  const std::lock_guard lock(mutex_);
  LoopQuality quality = quality_;
  quality.fifo = fifo_;
  return quality;
}

core::Status PacedRig::CheckEpoch(Epoch epoch) const {
  if (epoch >= epoch_) return core::Done{};
  return StaleEpoch(static_cast<std::int64_t>(epoch), static_cast<std::int64_t>(epoch_));
}

core::Status PacedRig::Arm(RunPlan plan, Epoch epoch) {
  const std::lock_guard machine_lock(machine_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = CheckEpoch(epoch); !fresh) return fresh;
    if (state_ == RigState::kTripped) {
      return Conflict("the interlock " + trip_->name + " holds the rig: clear it first");
    }
    if (state_ != RigState::kIdle && state_ != RigState::kArmed) {
      return Conflict("the rig is " + std::string(Name(state_)));
    }
    if (auto good = machine_->Check(plan); !good) return good;
    epoch_ = epoch;
  }
  if (loop_.joinable()) loop_.join();  // the loop of the run before has ended: its state said so
  try {
    machine_->Prepare(plan);
  } catch (const std::exception& error) {
    const std::string unsafe = machine_->MakeSafe();
    if (!unsafe.empty()) {
      const std::lock_guard lock(mutex_);
      Latch(machine_->trip().value_or(Trip{.name = "unsafe", .text = unsafe}));
      state_ = RigState::kTripped;
      queue_.Close();
    }
    return core::Error{.code = core::ErrorCode::kUnavailable,
                       .message = std::string("the rig does not get ready: ") + error.what() +
                                  (unsafe.empty() ? "" : "; " + unsafe),
                       .field = {}};
  }
  const std::lock_guard lock(mutex_);
  queue_.Reopen();
  commands_.clear();
  asked_at_.fill(kNotAsked);
  stop_reason_.reset();
  safe_after_.reset();
  stop_asked_ = false;
  in_step_ = options_.wait_for_reader && plan.control.has_value();
  period_ = Nanoseconds(std::llround(plan.period_s * 1e9));
  planned_ = shift_ = Nanoseconds(0);
  next_index_ = 0;
  consecutive_overruns_ = 0;
  first_step_ = true;
  state_ = RigState::kArmed;
  return core::Done{};
}

core::Status PacedRig::Start(Epoch epoch) {
  const std::lock_guard machine_lock(machine_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = CheckEpoch(epoch); !fresh) return fresh;
    if (state_ != RigState::kArmed) {
      return Conflict("the rig is " + std::string(Name(state_)) + ", not armed");
    }
    state_ = RigState::kRunning;
  }
  HeardFrom();
  if (options_.heartbeat) options_.heartbeat->Begin();
  try {
    loop_ = std::jthread([this] {
      fifo_ = AskForFifo(options_.fifo_priority);
      if (!fifo_ && !options_.wait_for_reader) AskForShortSlices();
      RunLoop(*options_.clock, [this](const Wake& wake) { return Step(wake); });
    });
  } catch (const std::exception& error) {
    if (options_.heartbeat) options_.heartbeat->End();
    const std::lock_guard lock(mutex_);
    state_ = RigState::kIdle;
    queue_.Close();
    state_changed_.notify_all();
    return core::Error{.code = core::ErrorCode::kUnavailable,
                       .message = std::string("no loop for the rig: ") + error.what(),
                       .field = {}};
  }
  return core::Done{};
}

core::Status PacedRig::Command(Epoch epoch, const RigCommand& command) {
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = CheckEpoch(epoch); !fresh) return fresh;
    HeardFrom();
    if (command.kind != RigCommand::Kind::kClearTrip && state_ == RigState::kRunning) {
      if (auto good = machine_->Check(command); !good) return good;
      if (commands_.size() >= kCommandsMax) {
        return core::Error{.code = core::ErrorCode::kBusy,
                           .message = "too many commands for one tick: try again",
                           .field = {}};
      }
      commands_.push_back(command);
      if (command.kind == RigCommand::Kind::kSetComponent) {
        asked_at_[static_cast<std::size_t>(core::Index(command.component))] = options_.wall->Now();
      }
      return core::Done{};
    }
    const bool of_a_run = command.kind == RigCommand::Kind::kSetComponent ||
                          command.kind == RigCommand::Kind::kControl;
    if (of_a_run || state_ == RigState::kRunning || state_ == RigState::kStopping) {
      return Conflict("the rig is " + std::string(Name(state_)) +
                      ": components are set while it runs");
    }
  }
  // Idle, armed or tripped: all nominal, and with kClearTrip the latch opened if that worked.
  const std::lock_guard machine_lock(machine_mutex_);
  const std::string unsafe = machine_->MakeSafe();
  if (!unsafe.empty()) {
    return core::Error{
        .code = core::ErrorCode::kUnavailable, .message = "not safe: " + unsafe, .field = {}};
  }
  const std::lock_guard lock(mutex_);
  if (command.kind == RigCommand::Kind::kClearTrip && state_ == RigState::kTripped) {
    machine_->ClearTrip();
    trip_.reset();
    state_ = RigState::kIdle;
  }
  return core::Done{};
}

void PacedRig::HeardFrom() {
  heard_at_ns_.store(options_.wall->Now().count(), std::memory_order_relaxed);
}

bool PacedRig::HolderIsSilent() const {
  if (options_.watchdog.count() == 0 || readers_ > 0) return false;
  const Nanoseconds heard_at(heard_at_ns_.load(std::memory_order_relaxed));
  return options_.wall->Now() - heard_at > options_.watchdog;
}

void PacedRig::KeepAlive(Epoch epoch) {
  const std::lock_guard lock(mutex_);
  if (CheckEpoch(epoch)) HeardFrom();
}

ReadStatus PacedRig::Read(std::vector<RigMessage>& out, std::chrono::milliseconds patience) {
  ++readers_;
  HeardFrom();
  const bool open = queue_.TakeAll(out, patience);
  HeardFrom();
  --readers_;
  return open ? ReadStatus::kMore : ReadStatus::kEnded;
}

void PacedRig::Fence(Epoch epoch) {
  {
    const std::lock_guard lock(mutex_);
    if (epoch <= epoch_) return;
    epoch_ = epoch;
  }
  SafeStop("the lease was revoked");
}

void PacedRig::SafeStop(std::string_view reason) {
  const Nanoseconds asked_at = options_.wall->Now();
  {
    const std::lock_guard lock(mutex_);
    if (!stop_reason_) stop_reason_ = std::string(reason);
    stop_asked_ = true;
  }
  {
    // At once, whatever the loop waits for; it does the same again when it sees the request.
    const std::lock_guard machine_lock(machine_mutex_);
    const std::string unsafe = machine_->MakeSafe();
    const std::lock_guard lock(mutex_);
    if (unsafe.empty()) NoteSafe(asked_at);
    if (state_ == RigState::kArmed) {
      state_ = RigState::kIdle;
      queue_.Close();
    }
    if (!unsafe.empty() && state_ == RigState::kIdle) {
      Latch(machine_->trip().value_or(Trip{.name = "unsafe", .text = unsafe}));
      state_ = RigState::kTripped;
    }
  }
  queue_.Wake();
  std::unique_lock lock(mutex_);
  state_changed_.wait(
      lock, [this] { return state_ != RigState::kRunning && state_ != RigState::kStopping; });
}

core::Result<SelfTestReport> PacedRig::SelfTest(Epoch epoch) {
  const std::lock_guard machine_lock(machine_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = CheckEpoch(epoch); !fresh) return fresh.error();
    if (state_ != RigState::kIdle) return Conflict("the rig is " + std::string(Name(state_)));
    epoch_ = epoch;
  }
  SelfTestReport report;
  try {
    report = machine_->SelfTest();
  } catch (const std::exception& error) {
    report.ok = false;
    report.positions.push_back(
        {.component = {}, .value = 0.0, .line = "", .ok = false, .text = error.what()});
  }
  if (!machine_->MakeSafe().empty()) report.ok = false;
  return report;
}

}  // namespace faultlab::hardware
