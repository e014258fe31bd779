#include "hardware/lcm/rig_agent.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/types/check.h"
#include "faultlab_msgs/rig_announce_t.hpp"
#include "faultlab_msgs/rig_stream_t.hpp"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/message_codec.h"

namespace faultlab::hardware {
namespace {

constexpr Nanoseconds kAnnounceEvery = std::chrono::milliseconds(500);
constexpr std::size_t kRepliesKept = 64;
/// Holders need the key, so only our own servers can fill this.
constexpr std::size_t kHoldersMax = 4096;

void Refuse(faultlab_msgs::rig_reply_t& reply, const core::Error& error) {
  reply.ok = 0;
  reply.code = static_cast<std::int8_t>(error.code);
  reply.message = error.message;
  reply.field = error.field;
}

void Answer(faultlab_msgs::rig_reply_t& reply, const core::Status& status) {
  if (!status) Refuse(reply, status.error());
}

std::int64_t ToInt(Epoch epoch) {
  return static_cast<std::int64_t>(epoch);
}

}  // namespace

RigAgent::RigAgent(Rig& rig,
                   MessageBus& bus,
                   RigAgentSettings settings,
                   std::function<Nanoseconds()> now,
                   std::function<std::int64_t()> unix_ns)
    : rig_(rig),
      bus_(bus),
      settings_(std::move(settings)),
      now_(std::move(now)),
      unix_ns_(std::move(unix_ns)),
      id_(rig.description().id),
      boot_(RandomId()) {
  LAB_CHECK(IsRigName(id_), id_);
  LAB_CHECK(settings_.lease > settings_.watchdog);
  bus_.Subscribe(CommandChannel(id_),
                 [this](const std::string&, MessageBus::Bytes bytes) { OnCommand(bytes); });
}

RigAgent::~RigAgent() {
  rig_.SafeStop("the agent ends");
}

void RigAgent::EndLease(std::string_view reason) {
  if (holder_.empty()) return;
  holder_.clear();
  epoch_ = Epoch{static_cast<std::uint64_t>(epoch_) + 1};
  rig_.Fence(epoch_);
  rig_.SafeStop(reason);
  announced_at_ = Nanoseconds(-1);
}

void RigAgent::OnCommand(MessageBus::Bytes bytes) {
  const std::int64_t received_ns = unix_ns_();
  const std::optional<Command> command = Verified<Command>(bytes, settings_.key);
  if (!command || command->rig != id_) {
    ++counts_.forged;
    return;
  }
  if (command->boot != boot_) {
    ++counts_.replayed;
    return;
  }
  const auto known = counters_.find(command->holder);
  if (known == counters_.end() ? counters_.size() >= kHoldersMax
                               : command->counter <= known->second) {
    ++counts_.replayed;
    return;
  }
  counters_[command->holder] = command->counter;

  // A repetition of what was answered (the answer was lost) must not act twice.
  for (Reply& before : replies_) {
    if (before.holder == command->holder && before.request == command->request) {
      Send(before);
      return;
    }
  }
  Reply reply;
  reply.rig = id_;
  reply.boot = boot_;
  reply.holder = command->holder;
  reply.request = command->request;
  reply.ok = 1;
  reply.code = 0;
  reply.command_sent_ns = command->sent_ns;
  reply.received_ns = received_ns;
  reply.missing_count = reply.position_count = 0;

  if (command->action == "lease") {
    Lease(*command, reply);
  } else if (command->action == "refill") {
    // Reading is free to whoever has the key: after a long cut the lease is gone.
    if (command->from <= command->to) Refill(command->from, command->to);
  } else if (!Leased() || command->holder != holder_) {
    ++counts_.not_holder;
    Refuse(reply,
           {.code = core::ErrorCode::kStale,
            .message = Leased() ? "the rig is held by " + holder_ : "you hold no lease of this rig",
            .field = "holder"});
  } else if (command->epoch != ToInt(epoch_)) {
    ++counts_.stale;
    Refuse(reply,
           {.code = core::ErrorCode::kStale,
            .message = "epoch " + std::to_string(command->epoch) + " is not the rig's " +
                       std::to_string(ToInt(epoch_)),
            .field = "epoch"});
  } else {
    ++counts_.accepted;
    heard_at_ = now_();
    lease_until_ = heard_at_ + settings_.lease;
    rig_.KeepAlive(epoch_);
    Obey(*command, reply);
  }
  reply.epoch = ToInt(epoch_);
  reply.run = run_;
  Send(reply);
  // Refills are asked again when they are lost; the rest must be answered once.
  if (command->action == "refill" || command->action == "alive" || command->action == "plan") {
    return;
  }
  replies_.push_back(std::move(reply));
  if (replies_.size() > kRepliesKept) replies_.pop_front();
}

void RigAgent::Lease(const Command& command, Reply& reply) {
  if (Leased() && holder_ != command.holder) {
    ++counts_.not_holder;
    Refuse(reply,
           {.code = core::ErrorCode::kBusy,
            .message = "the rig is held by " + holder_,
            .field = "holder"});
    return;
  }
  EndLease("the lease was renewed with a new epoch");
  ++counts_.accepted;
  holder_ = command.holder;
  epoch_ = Epoch{static_cast<std::uint64_t>(epoch_) + 1};
  rig_.Fence(epoch_);
  heard_at_ = now_();
  lease_until_ = heard_at_ + settings_.lease;
  plan_chunks_.clear();
  announced_at_ = Nanoseconds(-1);
}

void RigAgent::Obey(const Command& command, Reply& reply) {
  const std::string& action = command.action;
  if (action == "alive") return;
  if (action == "release") {
    EndLease("the lease was given back");
  } else if (action == "plan") {
    TakePlan(command, reply);
  } else if (action == "arm") {
    Arm(command, reply);
  } else if (action == "start") {
    Answer(reply, rig_.Start(epoch_));
  } else if (action == "nominal") {
    Answer(reply, rig_.Command(epoch_, {.kind = RigCommand::Kind::kAllNominal}));
  } else if (action == "clear") {
    Answer(reply, rig_.Command(epoch_, {.kind = RigCommand::Kind::kClearTrip}));
  } else if (action == "set") {
    const std::optional<core::Component> component = core::ParseComponent(command.component);
    if (component) {
      Answer(reply,
             rig_.Command(epoch_,
                          {.kind = RigCommand::Kind::kSetComponent,
                           .component = *component,
                           .value = command.value}));
    } else {
      Refuse(reply,
             {.code = core::ErrorCode::kInvalid,
              .message = "no component " + command.component,
              .field = "component"});
    }
  } else if (action == "stop") {
    rig_.SafeStop(command.text);
  } else if (action == "self_test") {
    SelfTest(reply);
  } else {
    Refuse(reply,
           {.code = core::ErrorCode::kInvalid,
            .message = "this agent does not know \"" + action + "\"",
            .field = "action"});
  }
}

void RigAgent::TakePlan(const Command& command, Reply& reply) {
  if (command.from < 0 || command.from >= kPlanSamplesMax ||
      command.from % kPlanChunkSamples != 0 || command.uc_v.size() > kPlanChunkSamples) {
    Refuse(reply,
           {.code = core::ErrorCode::kTooLarge,
            .message =
                "not a piece of a plan: at most " + std::to_string(kPlanSamplesMax) + " samples",
            .field = "uc_v"});
    return;
  }
  plan_chunks_[command.from] = command.uc_v;
}

void RigAgent::Arm(const Command& command, Reply& reply) {
  StreamRun();  // the last words of the run before
  RunPlan plan;
  plan.period_s = command.period_s;
  plan.seed = static_cast<std::uint64_t>(command.seed);
  if (command.to < 0 || command.to > kPlanSamplesMax) {
    Refuse(
        reply,
        {.code = core::ErrorCode::kTooLarge, .message = "the plan is too long", .field = "uc_v"});
    return;
  }
  for (std::int64_t from = 0; from < command.to; from += kPlanChunkSamples) {
    const auto chunk = plan_chunks_.find(from);
    const auto size =
        static_cast<std::size_t>(std::min<std::int64_t>(kPlanChunkSamples, command.to - from));
    if (chunk == plan_chunks_.end() || chunk->second.size() != size) {
      if (reply.missing.size() < 64) reply.missing.push_back(from);
    } else {
      plan.uc_v.insert(plan.uc_v.end(), chunk->second.begin(), chunk->second.end());
    }
  }
  if (!reply.missing.empty()) {
    reply.missing_count = static_cast<std::int32_t>(reply.missing.size());
    Refuse(reply,
           {.code = core::ErrorCode::kUnavailable,
            .message = "parts of the plan were lost on the way",
            .field = "uc_v"});
    return;
  }
  for (const faultlab_msgs::fault_t& fault : command.faults) {
    const std::optional<core::Component> component = core::ParseComponent(fault.component);
    if (!component || fault.kind < 0 || fault.kind > 2) {
      Refuse(reply,
             {.code = core::ErrorCode::kInvalid,
              .message = "no such fault: " + fault.component,
              .field = "faults"});
      return;
    }
    plan.faults.push_back({.component = *component,
                           .value = fault.value,
                           .at_s = fault.at_s,
                           .kind = static_cast<core::FaultKind>(fault.kind),
                           .until_s = fault.until_s});
  }
  const core::Status armed = rig_.Arm(std::move(plan), epoch_);
  Answer(reply, armed);
  if (!armed) return;
  plan_chunks_.clear();
  ++run_;
  ring_.clear();
  ring_first_seq_ = 0;
}

void RigAgent::SelfTest(Reply& reply) {
  if (rig_.state() != RigState::kIdle) {
    Refuse(reply,
           {.code = core::ErrorCode::kConflict,
            .message = "the rig is " + std::string(Name(rig_.state())),
            .field = {}});
    return;
  }
  const SelfTestReport report = rig_.SelfTest();
  heard_at_ = now_();
  lease_until_ = heard_at_ + settings_.lease;
  reply.ok = report.ok ? 1 : 0;
  for (const SelfTestPosition& position : report.positions) {
    faultlab_msgs::rig_position_t out;
    out.component = core::Name(position.component);
    out.value = position.value;
    out.line = position.line;
    out.ok = position.ok ? 1 : 0;
    out.text = position.text;
    reply.positions.push_back(std::move(out));
  }
  reply.position_count = static_cast<std::int32_t>(reply.positions.size());
}

void RigAgent::Send(Reply& reply) {
  reply.sent_ns = unix_ns_();
  bus_.Publish(ReplyChannel(id_), SignedBytes(reply, settings_.key));
}

void RigAgent::PublishItems(std::int64_t from, std::int64_t to) {
  faultlab_msgs::rig_stream_t out;
  out.rig = id_;
  out.boot = boot_;
  out.run = run_;
  out.epoch = ToInt(epoch_);
  out.first_seq = from;
  out.oldest_seq = ring_first_seq_;
  for (std::int64_t seq = from; seq < to; ++seq) {
    out.items.push_back(ring_[static_cast<std::size_t>(seq - ring_first_seq_)]);
  }
  out.count = static_cast<std::int32_t>(out.items.size());
  const std::vector<std::uint8_t> bytes = SignedBytes(out, settings_.key);
  ++counts_.stream_messages;
  counts_.stream_bytes += bytes.size();
  bus_.Publish(StreamChannel(id_), bytes);
}

void RigAgent::Refill(std::int64_t from, std::int64_t to) {
  const std::int64_t next = ring_first_seq_ + static_cast<std::int64_t>(ring_.size());
  // An asker whose wish is gone must hear so: an empty message carries the oldest there is.
  from = std::clamp(from, ring_first_seq_, next);
  to = std::clamp(to, from, std::min(next, from + kRefillItemsMax));
  if (from == to) PublishItems(from, from);
  for (; from < to; from += kRefillItems) {
    const std::int64_t end = std::min<std::int64_t>(from + kRefillItems, to);
    counts_.refilled_items += static_cast<std::uint64_t>(end - from);
    PublishItems(from, end);
  }
}

void RigAgent::StreamRun() {
  messages_.clear();
  (void)rig_.Read(messages_, std::chrono::milliseconds(0));
  const std::int64_t first = ring_first_seq_ + static_cast<std::int64_t>(ring_.size());
  for (const RigMessage& message : messages_) {
    faultlab_msgs::rig_item_t item{};
    if (const auto* sample = std::get_if<core::Sample>(&message)) {
      item.index = sample->index;
      item.t_s = sample->t_s;
      item.uc_v = sample->uc_v;
      item.um_v = sample->um_v;
      item.ua_v = sample->ua_v;
      item.ia_a = sample->ia_a;
      item.n_rpm = sample->n_rpm;
    } else {
      const auto& event = std::get<RigEvent>(message);
      item.index = event.index;
      item.kind = Name(event.kind);
      item.component = core::Name(event.component);
      item.value = event.value;
      item.text = event.text;
    }
    ring_.push_back(std::move(item));
    if (ring_.size() > settings_.ring_items) {
      ring_.pop_front();
      ++ring_first_seq_;
    }
  }
  const std::int64_t next = ring_first_seq_ + static_cast<std::int64_t>(ring_.size());
  for (std::int64_t seq = std::max(first, ring_first_seq_); seq < next; seq += kRefillItems) {
    PublishItems(seq, std::min<std::int64_t>(seq + kRefillItems, next));
  }
}

void RigAgent::Poll() {
  StreamRun();
  const Nanoseconds now = now_();
  if (rig_.state() == RigState::kRunning && now - heard_at_ > settings_.watchdog) {
    rig_.SafeStop("watchdog: no word from the lease holder");
    StreamRun();
  }
  if (!holder_.empty() && !Leased()) EndLease("the lease ran out");
  const RigState state = rig_.state();
  if (announced_at_.count() < 0 || now - announced_at_ >= kAnnounceEvery ||
      state != announced_state_) {
    announced_at_ = now;
    announced_state_ = state;
    Announce();
  }
}

void RigAgent::Announce() {
  const RigDescription& description = rig_.description();
  const LoopQuality loop = rig_.loop_quality();
  faultlab_msgs::rig_announce_t out;
  out.rig = id_;
  out.boot = boot_;
  out.seq = announce_seq_++;
  out.sent_ns = unix_ns_();
  out.rig_class = description.rig_class;
  out.behind = Name(description.kind);
  out.profile = description.profile;
  out.has_ua = description.has_ua;
  out.has_ia = description.has_ia;
  out.has_n = description.has_n;
  out.any_value = description.any_value;
  out.motor_faults = description.motor_faults;
  out.current_mode = description.amplifier_mode == core::AmplifierMode::kCurrent;
  out.four_quadrants = description.amplifier_quadrants == core::Quadrants::kFour;
  out.uc_min_v = description.uc_v_min;
  out.uc_max_v = description.uc_v_max;
  out.delta_s = description.delta_s;
  out.calibration = settings_.calibration;
  out.state = Name(announced_state_);
  if (const std::optional<Trip> trip = rig_.trip()) out.health = trip->name + ": " + trip->text;
  out.epoch = ToInt(epoch_);
  out.holder = Leased() ? holder_ : "";
  out.lease_left_s = Leased() ? std::chrono::duration<double>(lease_until_ - now_()).count() : 0.0;
  out.run = run_;
  out.run_next_seq = ring_first_seq_ + static_cast<std::int64_t>(ring_.size());
  out.loop_ticks = static_cast<std::int64_t>(loop.ticks);
  out.loop_overruns = static_cast<std::int64_t>(loop.overruns);
  out.loop_missed_ticks = static_cast<std::int64_t>(loop.missed_ticks);
  out.loop_worst_s = loop.lateness_worst_s;
  out.loop_fifo = loop.fifo;
  static_assert(LoopQuality::kBuckets == std::extent_v<decltype(out.loop_lateness)>);
  for (std::size_t i = 0; i < LoopQuality::kBuckets; ++i) {
    out.loop_lateness[i] = static_cast<std::int64_t>(loop.lateness[i]);
  }
  bus_.Publish(kAnnounceChannel, SignedBytes(out, settings_.key));
}

}  // namespace faultlab::hardware
