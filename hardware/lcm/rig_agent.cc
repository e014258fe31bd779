#include "hardware/lcm/rig_agent.h"

#include <utility>

#include "core/types/check.h"
#include "core/types/number_text.h"
#include "faultlab_msgs/rig_announce_t.hpp"
#include "faultlab_msgs/rig_bench_t.hpp"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/control_codec.h"
#include "hardware/lcm/holder_name.h"
#include "hardware/lcm/rig_codec.h"
#include "hardware/lcm/rig_name.h"
#include "hardware/lcm/sealed_message.h"

namespace faultlab::hardware {
namespace {

constexpr std::size_t kHolderBytesMax = 200;
constexpr Nanoseconds kAnnounceEvery = std::chrono::milliseconds(500);
constexpr std::int64_t kAnnouncesPerDescription = 4;
/// Items of a live message: with its head they fit the shortest sealed message.
constexpr std::size_t kLivePieceBytes = kShortMessageBytes - 160;
/// More than this is no fault's doing: the agent was held up, and catches up.
constexpr std::int64_t kLiveItemsWaitingMax = 64;

void Refuse(faultlab_msgs::rig_reply_t& reply, const core::Error& error) {
  reply.ok = 0;
  reply.code = static_cast<std::int8_t>(error.code);
  reply.message = error.message;
  reply.field = error.field;
}

void Tell(faultlab_msgs::rig_reply_t& reply, const core::Status& status) {
  if (!status) Refuse(reply, status.error());
}

std::int64_t ToInt(Epoch epoch) {
  return static_cast<std::int64_t>(epoch);
}

}  // namespace

RigAgent::RigAgent(Rig& rig,
                   MessageBus& bus,
                   RigAgentSettings settings,
                   EpochFile epochs,
                   std::function<Nanoseconds()> now,
                   std::function<std::int64_t()> unix_ns)
    : rig_(rig),
      bus_(bus),
      settings_(std::move(settings)),
      now_(std::move(now)),
      unix_ns_(std::move(unix_ns)),
      id_(rig.description().id),
      reply_channel_(ReplyChannel(id_)),
      stream_channel_(StreamChannel(id_)),
      boot_(RandomId()),
      epochs_(std::move(epochs)),
      gate_(id_, settings_.key, boot_),
      ring_(settings_.ring_items) {
  LAB_CHECK(IsRigName(id_), id_);
  LAB_CHECK(settings_.lease > settings_.watchdog);
  rig_.Fence(epoch());
  bus_.Subscribe(CommandChannel(id_),
                 [this](const std::string&, MessageBus::Bytes bytes) { OnCommand(bytes); });
}

RigAgent::~RigAgent() {
  rig_.SafeStop("the agent ends");
}

void RigAgent::EndLease(std::string_view reason) {
  if (holder_.empty()) return;
  holder_.clear();
  rig_.SafeStop(reason);
  announced_at_ = Nanoseconds(-1);
}

void RigAgent::OnCommand(MessageBus::Bytes bytes) {
  const std::int64_t received_ns = unix_ns_();
  Command command;
  switch (gate_.Check(bytes, command)) {
    case CommandAuthenticator::Verdict::kForged:
      ++counts_.forged;
      return;
    case CommandAuthenticator::Verdict::kReplayed:
      ++counts_.replayed;
      return;
    case CommandAuthenticator::Verdict::kRepeated:
      Send(*gate_.Remembered(command));
      return;
    case CommandAuthenticator::Verdict::kNew:
      break;
  }
  Reply reply = Answer(command, received_ns);
  Send(reply);
  // Refills are asked again when they are lost; the rest must be answered once.
  if (command.action == "refill" || command.action == "alive" || command.action == "plan") return;
  gate_.Remember(std::move(reply));
}

RigAgent::Reply RigAgent::Answer(const Command& command, std::int64_t received_ns) {
  Reply reply;
  reply.rig = id_;
  reply.boot = boot_;
  reply.holder = command.holder;
  reply.request = command.request;
  reply.ok = 1;
  reply.code = 0;
  reply.command_sent_ns = command.sent_ns;
  reply.received_ns = received_ns;
  reply.missing_count = reply.position_count = 0;

  if (command.action == "lease") {
    Lease(command, reply);
  } else if (command.action == "refill") {
    // Reading is free to whoever has the key: after a long cut the lease is gone.
    if (command.from <= command.to) Refill(command.from, command.to);
  } else if (!Leased() || command.holder != holder_) {
    ++counts_.not_holder;
    Refuse(reply,
           {.code = core::ErrorCode::kStale,
            .message = Leased() ? "the rig is held by " + holder_ : "you hold no lease of this rig",
            .field = "holder"});
  } else if (command.epoch != ToInt(epoch())) {
    ++counts_.stale;
    Refuse(reply,
           {.code = core::ErrorCode::kStale,
            .message = "epoch " + std::to_string(command.epoch) + " is not the rig's " +
                       std::to_string(ToInt(epoch())),
            .field = "epoch"});
  } else {
    ++counts_.accepted;
    heard_at_ = now_();
    lease_until_ = heard_at_ + settings_.lease;
    rig_.KeepAlive(epoch());
    Obey(command, reply);
  }
  reply.epoch = ToInt(epoch());
  reply.run = run_;
  return reply;
}

std::optional<core::Error> RigAgent::RefuseLease(const Command& command) const {
  const std::string field(kLeaseField);
  if (command.epoch < 1 || command.holder.empty() ||
      ShownText(command.holder, kHolderBytesMax) != command.holder) {
    return core::Error{.code = core::ErrorCode::kInvalid,
                       .message =
                           "a lease needs a holder and an epoch of its lab: is the server "
                           "of an older version than this agent?",
                       .field = field};
  }
  const core::Error busy{
      .code = core::ErrorCode::kBusy, .message = "the rig is held by " + holder_, .field = field};
  if (Leased() && LabOf(holder_) != LabOf(command.holder)) return busy;
  const SeenLease& seen = epochs_.seen();
  const auto epoch = static_cast<std::uint64_t>(command.epoch);
  const bool same = epoch == seen.epoch;
  if (epoch < seen.epoch || (same && LabOf(seen.holder) != LabOf(command.holder))) {
    return core::Error{.code = core::ErrorCode::kStale,
                       .message = "the rig has seen epoch " + std::to_string(seen.epoch) + " of " +
                                  seen.holder + ", this lease is of epoch " + std::to_string(epoch),
                       .field = field};
  }
  // The very lease that another member has, or this one before it was started again: it is given
  // when that one has been silent for long enough.
  if (same && Leased() && holder_ != command.holder) {
    return core::Error{.code = core::ErrorCode::kUnavailable,
                       .message = "the rig still waits for " + holder_ +
                                  ", which had this lease: try again in a few seconds",
                       .field = field};
  }
  return std::nullopt;
}

void RigAgent::Lease(const Command& command, Reply& reply) {
  if (const std::optional<core::Error> refused = RefuseLease(command)) {
    ++(refused->code == core::ErrorCode::kStale ? counts_.stale : counts_.not_holder);
    Refuse(reply, *refused);
    return;
  }
  const Epoch asked{static_cast<std::uint64_t>(command.epoch)};
  const bool goes_on = asked == epoch() && Leased();  // asked twice
  if (!goes_on) {
    rig_.Fence(asked);  // stops what runs under an older one, before anything can fail
    EndLease("the lease has ended");
  }
  const core::Status kept = epochs_.Raise({static_cast<std::uint64_t>(asked), command.holder});
  if (!kept) {
    EndLease("the agent cannot keep its epoch");
    Refuse(reply, {kept.error().code, kept.error().message, std::string(kLeaseField)});
    return;
  }
  ++counts_.accepted;
  heard_at_ = now_();
  lease_until_ = heard_at_ + settings_.lease;
  if (goes_on) return;
  holder_ = command.holder;
  plan_.Clear();
  announced_at_ = Nanoseconds(-1);
}

void RigAgent::Obey(const Command& command, Reply& reply) {
  const std::string& action = command.action;
  if (action == "alive") return;
  if (action == "release") {
    EndLease("the lease was given back");
  } else if (action == "plan") {
    Tell(reply, plan_.Take(command));
  } else if (action == "arm") {
    Arm(command, reply);
  } else if (action == "start") {
    Tell(reply, rig_.Start(epoch()));
  } else if (action == "nominal") {
    Tell(reply, rig_.Command(epoch(), {.kind = RigCommand::Kind::kAllNominal}));
  } else if (action == "clear") {
    Tell(reply, rig_.Command(epoch(), {.kind = RigCommand::Kind::kClearTrip}));
  } else if (action == "set") {
    const std::optional<core::Component> component =
        rig_.description().bench->Find(command.component);
    if (component) {
      Tell(reply,
           rig_.Command(epoch(),
                        {.kind = RigCommand::Kind::kSetComponent,
                         .component = *component,
                         .value = command.value}));
    } else {
      Refuse(reply,
             {.code = core::ErrorCode::kInvalid,
              .message = "no component " + command.component,
              .field = "component"});
    }
  } else if (action == "control") {
    Order(command, reply);
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

void RigAgent::Arm(const Command& command, Reply& reply) {
  StreamRun();  // the last words of the run before
  core::Result<RunPlan> plan = plan_.Assemble(command, *rig_.description().bench, reply.missing);
  reply.missing_count = static_cast<std::int32_t>(reply.missing.size());
  if (!plan) {
    Refuse(reply, plan.error());
    return;
  }
  const core::Status armed = rig_.Arm(std::move(plan).value(), epoch());
  Tell(reply, armed);
  if (!armed) return;
  plan_.Clear();
  ++run_;
  ring_.Begin();
  streamed_seq_ = 0;
}

void RigAgent::Order(const Command& command, Reply& reply) {
  RigCommand order{.kind = RigCommand::Kind::kControl};
  if (!command.orders.empty()) {
    order.control = FromMessage(command.orders.front(), *rig_.description().bench);
  }
  if (order.control) {
    Tell(reply, rig_.Command(epoch(), order));
  } else {
    Refuse(reply,
           {.code = core::ErrorCode::kInvalid,
            .message = "no order, or one of a component that the bench does not have",
            .field = "control"});
  }
}

void RigAgent::SelfTest(Reply& reply) {
  const core::Result<SelfTestReport> report = rig_.SelfTest(epoch());
  if (!report) {
    Refuse(reply, report.error());
    return;
  }
  heard_at_ = now_();
  lease_until_ = heard_at_ + settings_.lease;
  reply.ok = report.value().ok ? 1 : 0;
  for (const SelfTestPosition& position : report.value().positions) {
    reply.positions.push_back(ToPosition(position));
  }
  reply.position_count = static_cast<std::int32_t>(reply.positions.size());
}

void RigAgent::Send(Reply reply) {
  reply.sent_ns = unix_ns_();
  bus_.Publish(reply_channel_, Sealed(reply, reply_channel_, settings_.key));
}

void RigAgent::PublishPieces(std::int64_t from, std::int64_t to) {
  for (faultlab_msgs::rig_stream_t& piece : ring_.Pieces(from, to)) Publish(std::move(piece));
}

void RigAgent::Publish(faultlab_msgs::rig_stream_t piece) {
  piece.rig = id_;
  piece.boot = boot_;
  piece.run = run_;
  piece.epoch = ToInt(epoch());
  const std::vector<std::uint8_t> bytes = Sealed(piece, stream_channel_, settings_.key);
  ++counts_.stream_messages;
  counts_.stream_bytes += bytes.size();
  bus_.Publish(stream_channel_, bytes);
}

void RigAgent::Refill(std::int64_t from, std::int64_t to) {
  const std::uint64_t before = counts_.stream_messages;
  PublishPieces(from, to);
  counts_.refill_messages += counts_.stream_messages - before;
}

void RigAgent::Log(const RigEvent& event) const {
  const std::string run = "run " + std::to_string(run_);
  const std::string at = " at sample " + std::to_string(event.index);
  if (event.kind == RigEventKind::kStarted) {
    settings_.say(run + " begins, epoch " + std::to_string(ToInt(epoch())) + " of " + holder_);
  } else if (event.kind == RigEventKind::kFinished) {
    settings_.say(run + " has been played to its end" + at);
  } else if (event.kind == RigEventKind::kStopped) {
    const std::string after = core::Format(", bench safe after %.1f ms: ", 1e3 * event.value);
    settings_.say(run + " stopped" + at + (event.value > 0.0 ? after : ": ") + event.text);
  }
}

/// While a run lasts, each message follows a sample and is of one length: the events of a fault
/// ride with samples, and where they are many, some ride with the next. Who listens to the bus
/// sees the samples' beat and nothing else.
void RigAgent::StreamRun() {
  messages_.clear();
  (void)rig_.Read(messages_, std::chrono::milliseconds(0));
  bool sampled = false;
  for (const RigMessage& message : messages_) {
    ring_.Push(message);
    if (const auto* event = std::get_if<RigEvent>(&message)) Log(*event);
    sampled = sampled || std::holds_alternative<core::Sample>(message);
  }
  const bool running = rig_.state() == RigState::kRunning;
  if (running && !sampled) return;
  const std::int64_t may_wait = running ? kLiveItemsWaitingMax : 0;
  do {
    if (streamed_seq_ == ring_.next_seq()) return;
    faultlab_msgs::rig_stream_t piece = ring_.PieceOf(streamed_seq_, kLivePieceBytes);
    streamed_seq_ = piece.first_seq + piece.count;
    Publish(std::move(piece));
  } while (ring_.next_seq() - streamed_seq_ > may_wait);
}

void RigAgent::Poll() {
  StreamRun();
  const Nanoseconds now = now_();
  if (rig_.state() == RigState::kRunning && now - heard_at_ > settings_.watchdog) {
    const auto silence = std::chrono::duration_cast<std::chrono::milliseconds>(now - heard_at_);
    settings_.say("no word from " + holder_ + " for " + std::to_string(silence.count()) +
                  " ms: the motor is stopped");
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
  faultlab_msgs::rig_announce_t out;
  out.rig = id_;
  out.boot = boot_;
  out.seq = announce_seq_++;
  out.sent_ns = unix_ns_();
  Encode(rig_.description(), out);
  Encode(rig_.trip(), out);
  Encode(rig_.loop_quality(), out);
  out.calibration = settings_.calibration;
  out.state = Name(announced_state_);
  out.epoch = ToInt(epoch());
  out.holder = Leased() ? holder_ : "";
  out.lease_left_s = Leased() ? std::chrono::duration<double>(lease_until_ - now_()).count() : 0.0;
  out.run = run_;
  out.run_next_seq = streamed_seq_;
  bus_.Publish(kAnnounceChannel, Sealed(out, kAnnounceChannel, settings_.key));
  if (out.seq % kAnnouncesPerDescription == 0) Describe();
}

/// The text is too long for each announcement: a message of several datagrams is lost more often
/// than one of one.
void RigAgent::Describe() {
  faultlab_msgs::rig_bench_t out;
  out.rig = id_;
  out.text = rig_.description().bench->text;
  const std::string channel = BenchChannel(id_);
  bus_.Publish(channel, Sealed(out, channel, settings_.key));
}

}  // namespace faultlab::hardware
