// A far rig as its holder sees it; what the bus says of it is in remote_rig_bus.cc.
#include "hardware/lcm/remote_rig.h"

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

#include "hardware/lcm/channels.h"
#include "hardware/lcm/control_codec.h"
#include "hardware/lcm/holder_name.h"
#include "hardware/lcm/rig_codec.h"

namespace faultlab::hardware {
namespace {

constexpr Nanoseconds kLate = std::chrono::milliseconds(500);
constexpr Nanoseconds kLost = std::chrono::seconds(2);
constexpr int kUploadRounds = 20;
/// Pieces of a plan sent at once: well inside a default socket buffer.
constexpr int kUploadBurst = 32;

core::Error Unavailable(std::string message) {
  return {.code = core::ErrorCode::kUnavailable, .message = std::move(message), .field = {}};
}

core::Error Conflict(std::string message) {
  return {.code = core::ErrorCode::kConflict, .message = std::move(message), .field = {}};
}

}  // namespace

std::string_view Name(LinkState state) {
  constexpr std::array<std::string_view, 3> kNames = {"back", "late", "lost"};
  return kNames[static_cast<std::size_t>(state)];
}

RemoteRig::RemoteRig(std::string id,
                     std::shared_ptr<MessageBus> bus,
                     RemoteRigSettings settings,
                     std::function<Nanoseconds()> now,
                     std::function<std::int64_t()> unix_ns)
    : id_(std::move(id)),
      stream_channel_(StreamChannel(id_)),
      settings_(std::move(settings)),
      now_(now),
      line_({.rig = id_,
             .holder = settings_.holder,
             .key = settings_.key,
             .retry = settings_.retry,
             .give_up = settings_.give_up},
            std::move(bus),
            std::move(now),
            std::move(unix_ns)),
      queue_(settings_.queue_messages) {
  description_.id = id_;
  description_.kind = RigKind::kRemote;
}

RemoteRig::~RemoteRig() {
  if (const auto epoch = line_.leased()) line_.Tell(line_.NewCommand("release", *epoch));
}

LinkState RemoteRig::Link() const {
  if (heard_at_.count() < 0) return LinkState::kLost;
  const Nanoseconds silence = now_() - heard_at_;
  return silence > kLost ? LinkState::kLost : silence > kLate ? LinkState::kLate : LinkState::kBack;
}

RigState RemoteRig::state() const {
  const std::lock_guard lock(mutex_);
  if (run_state_ == RigState::kRunning) return run_state_;  // even while the link is down
  if (Link() == LinkState::kLost || !announced_) return RigState::kOffline;
  if (run_state_ == RigState::kArmed) return run_state_;
  return ParseRigState(announced_->state).value_or(RigState::kOffline);
}

std::optional<Trip> RemoteRig::trip() const {
  const std::lock_guard lock(mutex_);
  return announced_ ? DecodeTrip(*announced_) : std::nullopt;
}

LoopQuality RemoteRig::loop_quality() const {
  const std::lock_guard lock(mutex_);
  return announced_ ? DecodeLoop(*announced_) : LoopQuality{};
}

/// Call with mutex_ held. A rig that we hear is not made another by what else says its name.
std::optional<RigRefusal> RemoteRig::Refusal() const {
  if (Link() == LinkState::kLost) {
    if (foreign_protocol_) return RigRefusal::kOtherProtocol;
    if (other_key_) return RigRefusal::kOtherKey;
    return std::nullopt;
  }
  const bool held = announced_ && !announced_->holder.empty();
  if (held && LabOf(announced_->holder) != LabOf(settings_.holder)) {
    return RigRefusal::kHeldElsewhere;
  }
  return std::nullopt;
}

std::optional<std::chrono::nanoseconds> RemoteRig::silence() const {
  const std::lock_guard lock(mutex_);
  return now_() - heard_at_;
}

RemoteRigInfo RemoteRig::info() const {
  RemoteRigInfo info;
  info.state = state();
  info.loop = loop_quality();
  info.trip = trip();
  info.key_known = true;
  info.held_by_us = line_.leased().has_value();
  const ClockOffset offset = line_.clock_offset();
  info.clock_offset_s = offset.offset_s();
  info.round_trip_s = offset.round_trip_s();
  const std::lock_guard lock(mutex_);
  info.description = description_;
  info.link = Link();
  info.silent_s =
      heard_at_.count() < 0 ? 0.0 : std::chrono::duration<double>(now_() - heard_at_).count();
  info.gaps_refilled = assembly_.refilled();
  info.refusal = Refusal();
  if (info.refusal) {
    info.refusal_text = RefusalText(*info.refusal, announced_ ? announced_->holder : "");
  }
  if (!announced_) return info;
  info.behind = announced_->behind == Name(RigKind::kBench) ? RigKind::kBench : RigKind::kSimulated;
  info.holder = announced_->holder;
  info.epoch = Epoch{static_cast<std::uint64_t>(announced_->epoch)};
  info.calibration = announced_->calibration;
  return info;
}

core::Result<AgentClient::Reply> RemoteRig::Ask(AgentClient::Message message) {
  {
    const std::lock_guard lock(mutex_);
    if (Link() == LinkState::kLost) {
      return Unavailable("rig " + id_ + " is not heard");
    }
  }
  return line_.Ask(std::move(message));
}

/// Whatever stands between us and the lease but a newer lease of our own is told as kLeaseField.
core::Status RemoteRig::Lease(Epoch epoch) {
  if (line_.leased() == epoch) return core::Done{};
  core::Status leased = core::Done{};
  {
    const std::lock_guard lock(mutex_);
    if (Link() == LinkState::kLost) {
      leased = Unavailable("rig " + id_ + " is not heard");
    }
  }
  if (leased) leased = line_.Lease(epoch);
  if (leased) return leased;
  core::Error error = leased.error();
  if (error.code != core::ErrorCode::kStale) error.field = kLeaseField;
  return error;
}

core::Status RemoteRig::Upload(const RunPlan& plan, Epoch epoch, std::int64_t& run) {
  const auto size = static_cast<std::int64_t>(plan.uc_v.size());
  std::vector<std::int64_t> missing;
  for (std::int64_t from = 0; from < size; from += kPlanChunkSamples) missing.push_back(from);
  for (int round = 0; round < kUploadRounds; ++round) {
    int burst = 0;
    for (const std::int64_t from : missing) {
      AgentClient::Message chunk = line_.NewCommand("plan", epoch);
      chunk.from = from;
      const std::int64_t to = std::min<std::int64_t>(from + kPlanChunkSamples, size);
      chunk.uc_v.assign(plan.uc_v.begin() + from, plan.uc_v.begin() + to);
      chunk.uc_count = static_cast<std::int32_t>(chunk.uc_v.size());
      line_.Tell(std::move(chunk));
      if (++burst % kUploadBurst == 0) std::this_thread::yield();
    }
    AgentClient::Message arm = line_.NewCommand("arm", epoch);
    arm.to = size;
    arm.period_s = plan.period_s;
    arm.seed = static_cast<std::int64_t>(plan.seed);
    for (const core::Fault& fault : plan.faults) arm.faults.push_back(ToMessage(fault));
    arm.fault_count = static_cast<std::int32_t>(arm.faults.size());
    if (plan.control) arm.references.push_back(ToMessage(*plan.control));
    arm.reference_count = static_cast<std::int32_t>(arm.references.size());
    TRY(const auto reply, Ask(std::move(arm)));
    if (reply.missing_count == 0) {
      run = reply.run;
      return core::Done{};
    }
    missing = reply.missing;
  }
  return Unavailable("the plan does not get through to rig " + id_);
}

core::Status RemoteRig::Arm(RunPlan plan, Epoch epoch) {
  const std::lock_guard control(control_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = line_.Check(epoch); !fresh) return fresh;
    if (run_state_ == RigState::kRunning) return Conflict("the rig is running");
    holder_word_at_ = now_();
  }
  if (auto leased = Lease(epoch); !leased) return leased;
  std::int64_t run = -1;
  core::Status armed = Upload(plan, epoch, run);
  if (!armed && armed.error().code == core::ErrorCode::kStale && line_.leased() != epoch) {
    // Our lease ran out between two runs: once more from the start.
    if (auto leased = Lease(epoch); !leased) return leased;
    armed = Upload(plan, epoch, run);
  }
  if (!armed) return armed;
  const std::lock_guard lock(mutex_);
  if (auto fresh = line_.Check(epoch); !fresh) return fresh;
  assembly_.Begin(run, *description_.bench);
  queue_.Reopen();
  run_state_ = RigState::kArmed;
  return core::Done{};
}

std::string RemoteRig::kept_run() const {
  const std::lock_guard lock(mutex_);
  if (!announced_ || assembly_.run() < 0) return {};
  return std::to_string(announced_->boot) + "/" + std::to_string(assembly_.run());
}

core::Status RemoteRig::Resume(const std::string& kept_run) {
  const std::lock_guard control(control_mutex_);
  const std::lock_guard lock(mutex_);
  if (run_state_ != RigState::kIdle) {
    return Conflict("the rig is " + std::string(Name(run_state_)));
  }
  if (Link() == LinkState::kLost || !announced_ || !described_) {
    return Unavailable("rig " + id_ + " is not heard");
  }
  const bool begun = announced_->run_next_seq > 0 || announced_->state == Name(RigState::kRunning);
  const std::string newest =
      std::to_string(announced_->boot) + "/" + std::to_string(announced_->run);
  if (!begun || kept_run != newest) {
    return core::Error{.code = core::ErrorCode::kNotFound,
                       .message = "rig " + id_ + " has run " + newest + " now, not " + kept_run,
                       .field = {}};
  }
  assembly_.Begin(announced_->run, *description_.bench);
  assembly_.Expect(announced_->run_next_seq);
  queue_.Reopen();
  run_state_ = RigState::kRunning;
  return core::Done{};
}

core::Status RemoteRig::Start(Epoch epoch) {
  const std::lock_guard control(control_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = line_.Check(epoch); !fresh) return fresh;
    if (run_state_ != RigState::kArmed) return Conflict("the rig is not armed");
    holder_word_at_ = now_();
    run_state_ = RigState::kRunning;  // its first words may come before the answer
  }
  const core::Result<AgentClient::Reply> reply = Ask(line_.NewCommand("start", epoch));
  if (reply) return core::Done{};
  const std::lock_guard lock(mutex_);
  // Without an answer the rig may be running: its watchdog or our stream will tell.
  if (reply.error().code != core::ErrorCode::kUnavailable) run_state_ = RigState::kIdle;
  return reply.error();
}

core::Status RemoteRig::Command(Epoch epoch, const RigCommand& command) {
  const bool clears = command.kind == RigCommand::Kind::kClearTrip;
  const bool sets = command.kind == RigCommand::Kind::kSetComponent;
  const bool orders = command.kind == RigCommand::Kind::kControl;
  bool lease = false;
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = line_.Check(epoch); !fresh) return fresh;
    holder_word_at_ = now_();
    lease = run_state_ == RigState::kIdle && !sets && !orders;
  }
  if (lease) {
    const std::lock_guard control(control_mutex_);
    if (auto leased = Lease(epoch); !leased) return leased;
  }
  const char* action = sets ? "set" : orders ? "control" : clears ? "clear" : "nominal";
  AgentClient::Message message = line_.NewCommand(action, epoch);
  if (sets) message.component = core::Name(command.component);
  message.value = command.value;
  if (command.control) message.orders.push_back(ToMessage(*command.control));
  message.order_count = static_cast<std::int32_t>(message.orders.size());
  TRY_DONE(Ask(std::move(message)));
  const std::lock_guard lock(mutex_);
  if (clears && announced_ && run_state_ == RigState::kIdle) {
    // The next announcement will say so, too.
    Encode(std::nullopt, *announced_);
    announced_->state = Name(RigState::kIdle);
  }
  return core::Done{};
}

void RemoteRig::KeepAlive(Epoch epoch) {
  const std::lock_guard lock(mutex_);
  if (line_.Check(epoch)) holder_word_at_ = now_();
}

ReadStatus RemoteRig::Read(std::vector<RigMessage>& out, std::chrono::milliseconds patience) {
  ++readers_;
  const bool open = queue_.TakeAll(out, patience);
  {
    const std::lock_guard lock(mutex_);
    holder_word_at_ = now_();
  }
  --readers_;
  return open ? ReadStatus::kMore : ReadStatus::kEnded;
}

void RemoteRig::Fence(Epoch epoch) {
  const std::lock_guard lock(mutex_);
  if (!line_.Fence(epoch) || run_state_ != RigState::kArmed) return;
  run_state_ = RigState::kIdle;
  queue_.Close();
}

void RemoteRig::SafeStop(std::string_view reason) {
  {
    const std::lock_guard lock(mutex_);
    if (run_state_ == RigState::kArmed) {
      run_state_ = RigState::kIdle;
      queue_.Close();
    }
  }
  const std::optional<Epoch> epoch = line_.leased();
  if (!epoch) return;
  AgentClient::Message message = line_.NewCommand("stop", *epoch);
  message.text = std::string(reason);
  // A rig that cannot be reached stops by its own watchdog; its last words come with the refill.
  if (!Ask(std::move(message))) return;
  std::unique_lock lock(mutex_);
  if (announced_ && announced_->state == Name(RigState::kArmed)) {
    announced_->state = Name(RigState::kIdle);  // the next announcement will say so, too
  }
  run_ended_.wait_for(lock, settings_.give_up, [this] { return run_state_ != RigState::kRunning; });
}

core::Result<SelfTestReport> RemoteRig::SelfTest(Epoch epoch) {
  const std::lock_guard control(control_mutex_);
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = line_.Check(epoch); !fresh) return fresh.error();
    if (run_state_ != RigState::kIdle) {
      return Conflict("the rig is " + std::string(Name(run_state_)));
    }
    holder_word_at_ = now_();
  }
  if (auto leased = Lease(epoch); !leased) return leased.error();
  TRY(const auto reply, Ask(line_.NewCommand("self_test", epoch)));
  SelfTestReport report;
  report.ok = reply.ok != 0;
  for (const faultlab_msgs::rig_position_t& position : reply.positions) {
    report.positions.push_back(FromPosition(position, *description_.bench));
  }
  return report;
}

}  // namespace faultlab::hardware
