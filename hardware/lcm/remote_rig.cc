#include "hardware/lcm/remote_rig.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "core/types/check.h"
#include "faultlab_msgs/rig_stream_t.hpp"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/message_codec.h"

namespace faultlab::hardware {
namespace {

constexpr Nanoseconds kLate = std::chrono::milliseconds(500);
constexpr Nanoseconds kLost = std::chrono::seconds(2);
constexpr Nanoseconds kAliveEvery = std::chrono::milliseconds(100);
constexpr Nanoseconds kHolderSilent = std::chrono::milliseconds(500);
constexpr Nanoseconds kRefillEvery = std::chrono::milliseconds(100);
constexpr int kHolesAtOnce = 32;
constexpr int kUploadRounds = 20;
/// Pieces of a plan sent at once: well inside a default socket buffer.
constexpr int kUploadBurst = 32;

core::Error Unavailable(std::string message) {
  return {.code = core::ErrorCode::kUnavailable, .message = std::move(message), .field = {}};
}

std::optional<RigState> ParseState(const std::string& name) {
  for (const RigState state : {RigState::kOffline,
                               RigState::kIdle,
                               RigState::kArmed,
                               RigState::kRunning,
                               RigState::kStopping,
                               RigState::kTripped}) {
    if (Name(state) == name) return state;
  }
  return std::nullopt;
}

RigMessage ToMessage(const faultlab_msgs::rig_item_t& item) {
  if (item.kind.empty()) {
    return core::Sample{.index = item.index,
                        .t_s = item.t_s,
                        .uc_v = item.uc_v,
                        .um_v = item.um_v,
                        .ua_v = item.ua_v,
                        .ia_a = item.ia_a,
                        .n_rpm = item.n_rpm};
  }
  faultlab_msgs::event_t event;
  event.index = item.index;
  event.kind = item.kind;
  event.component = item.component;
  event.value = item.value;
  event.text = item.text;
  if (std::optional<RigEvent> known = Decode(event)) return *known;
  return RigEvent{.kind = RigEventKind::kRefused,
                  .index = item.index,
                  .text = "a message that this version does not know: " + item.kind};
}

bool EndsRun(const RigMessage& message) {
  const auto* event = std::get_if<RigEvent>(&message);
  return event != nullptr &&
         (event->kind == RigEventKind::kFinished || event->kind == RigEventKind::kStopped);
}

}  // namespace

std::string_view Name(LinkState state) {
  switch (state) {
    case LinkState::kBack:
      return "back";
    case LinkState::kLate:
      return "late";
    case LinkState::kLost:
      return "lost";
  }
  return "?";
}

RemoteRig::RemoteRig(std::string id,
                     std::shared_ptr<MessageBus> bus,
                     RemoteRigSettings settings,
                     std::function<Nanoseconds()> now,
                     std::function<std::int64_t()> unix_ns)
    : id_(std::move(id)),
      bus_(std::move(bus)),
      settings_(std::move(settings)),
      now_(std::move(now)),
      unix_ns_(std::move(unix_ns)),
      queue_(settings_.queue_messages) {
  LAB_CHECK(IsRigName(id_), id_);
  description_.id = id_;
  description_.kind = RigKind::kRemote;
}

RemoteRig::~RemoteRig() {
  const std::lock_guard lock(mutex_);
  if (agent_epoch_ < 0) return;
  Message release = NewCommand("release");
  release.request = next_request_++;
  Send(release);
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
  return ParseState(announced_->state).value_or(RigState::kOffline);
}

std::optional<Trip> RemoteRig::trip() const {
  const std::lock_guard lock(mutex_);
  if (!announced_ || announced_->health.empty()) return std::nullopt;
  const std::string& health = announced_->health;
  const std::size_t colon = health.find(": ");
  if (colon == std::string::npos) return Trip{.name = health, .text = health};
  return Trip{.name = health.substr(0, colon), .text = health.substr(colon + 2)};
}

LoopQuality RemoteRig::loop_quality() const {
  const std::lock_guard lock(mutex_);
  LoopQuality quality;
  if (!announced_) return quality;
  quality.ticks = static_cast<std::uint64_t>(announced_->loop_ticks);
  quality.overruns = static_cast<std::uint64_t>(announced_->loop_overruns);
  quality.missed_ticks = static_cast<std::uint64_t>(announced_->loop_missed_ticks);
  quality.lateness_worst_s = announced_->loop_worst_s;
  quality.fifo = announced_->loop_fifo != 0;
  for (std::size_t i = 0; i < LoopQuality::kBuckets; ++i) {
    quality.lateness[i] = static_cast<std::uint64_t>(announced_->loop_lateness[i]);
  }
  return quality;
}

RemoteRigInfo RemoteRig::info() const {
  RemoteRigInfo info;
  info.state = state();
  info.loop = loop_quality();
  const std::lock_guard lock(mutex_);
  info.description = description_;
  info.link = Link();
  info.key_known = settings_.key.has_value();
  info.clock_offset_s = offset_s_;
  info.round_trip_s = round_trip_s_;
  info.gaps_refilled = refilled_;
  info.held_by_us = agent_epoch_ >= 0;
  if (!announced_) return info;
  info.behind = announced_->behind == Name(RigKind::kBench) ? RigKind::kBench : RigKind::kSimulated;
  info.health = announced_->health;
  info.holder = announced_->holder;
  info.calibration = announced_->calibration;
  return info;
}

// ---- commands ---------------------------------------------------------------------------------

RemoteRig::Message RemoteRig::NewCommand(const std::string& action) const {
  Message message{};
  message.rig = id_;
  message.boot = boot_;
  message.holder = settings_.holder;
  message.epoch = agent_epoch_;
  message.action = action;
  return message;
}

/// Call with mutex_ held: counters leave in their order.
void RemoteRig::Send(Message& message) {
  message.counter = ++counter_;
  message.sent_ns = unix_ns_();
  bus_->Publish(CommandChannel(id_), SignedBytes(message, *settings_.key));
}

core::Result<RemoteRig::Reply> RemoteRig::Ask(Message message) {
  if (!settings_.key) {
    return core::Error{.code = core::ErrorCode::kForbidden,
                       .message = "the key of rig " + id_ + " is not here: copy " + id_ +
                                  ".key from the agent's key folder",
                       .field = "keys"};
  }
  std::unique_lock lock(mutex_);
  if (Link() == LinkState::kLost) return Unavailable("rig " + id_ + " is not heard");
  message.request = next_request_++;
  waiting_[message.request].reset();
  const Nanoseconds give_up_at = now_() + settings_.give_up;
  while (true) {
    Send(message);
    answered_.wait_for(
        lock, settings_.retry, [&] { return waiting_[message.request].has_value(); });
    if (std::optional<Reply>& reply = waiting_[message.request]) {
      Reply answer = std::move(*reply);
      waiting_.erase(message.request);
      if (answer.ok || answer.position_count > 0) return answer;
      if (answer.field == "holder" || answer.field == "epoch") agent_epoch_ = -1;
      if (answer.missing_count > 0) return answer;
      return core::Error{.code = static_cast<core::ErrorCode>(answer.code),
                         .message = answer.message,
                         .field = answer.field};
    }
    if (now_() >= give_up_at) {
      waiting_.erase(message.request);
      return Unavailable("rig " + id_ + " does not answer");
    }
  }
}

core::Status RemoteRig::Lease() {
  Message message;
  {
    const std::lock_guard lock(mutex_);
    message = NewCommand("lease");
  }
  const core::Result<Reply> reply = Ask(std::move(message));
  if (!reply) return reply.error();
  const std::lock_guard lock(mutex_);
  agent_epoch_ = reply.value().epoch;
  leased_for_ = local_epoch_;
  holder_word_at_ = now_();
  return core::Done{};
}

core::Status RemoteRig::CheckLocalEpoch(Epoch epoch) const {
  if (epoch >= local_epoch_) return core::Done{};
  return core::Error{.code = core::ErrorCode::kStale,
                     .message = "epoch " + std::to_string(static_cast<std::uint64_t>(epoch)) +
                                " is older than the rig's " +
                                std::to_string(static_cast<std::uint64_t>(local_epoch_)),
                     .field = "epoch"};
}

core::Status RemoteRig::Upload(const RunPlan& plan) {
  const auto size = static_cast<std::int64_t>(plan.uc_v.size());
  std::vector<std::int64_t> missing;
  for (std::int64_t from = 0; from < size; from += kPlanChunkSamples) missing.push_back(from);
  for (int round = 0; round < kUploadRounds; ++round) {
    int burst = 0;
    for (const std::int64_t from : missing) {
      const std::lock_guard lock(mutex_);
      Message chunk = NewCommand("plan");
      chunk.request = next_request_++;
      chunk.from = from;
      const std::int64_t to = std::min<std::int64_t>(from + kPlanChunkSamples, size);
      chunk.uc_v.assign(plan.uc_v.begin() + from, plan.uc_v.begin() + to);
      chunk.uc_count = static_cast<std::int32_t>(chunk.uc_v.size());
      Send(chunk);
      if (++burst % kUploadBurst == 0) std::this_thread::yield();
    }
    Message arm;
    {
      const std::lock_guard lock(mutex_);
      arm = NewCommand("arm");
    }
    arm.to = size;
    arm.period_s = plan.period_s;
    arm.seed = static_cast<std::int64_t>(plan.seed);
    for (const core::Fault& fault : plan.faults) {
      faultlab_msgs::fault_t out;
      out.component = core::Name(fault.component);
      out.value = fault.value;
      out.at_s = fault.at_s;
      out.kind = static_cast<std::int8_t>(fault.kind);
      out.until_s = fault.until_s;
      arm.faults.push_back(std::move(out));
    }
    arm.fault_count = static_cast<std::int32_t>(arm.faults.size());
    core::Result<Reply> reply = Ask(std::move(arm));
    if (!reply) return reply.error();
    if (reply.value().missing_count == 0) {
      const std::lock_guard lock(mutex_);
      run_ = reply.value().run;
      return core::Done{};
    }
    missing = reply.value().missing;
  }
  return Unavailable("the plan does not get through to rig " + id_);
}

core::Status RemoteRig::Arm(RunPlan plan, Epoch epoch) {
  const std::lock_guard control(control_mutex_);
  bool lease = false;
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = CheckLocalEpoch(epoch); !fresh) return fresh;
    if (run_state_ == RigState::kRunning) {
      return core::Error{
          .code = core::ErrorCode::kConflict, .message = "the rig is running", .field = {}};
    }
    local_epoch_ = epoch;
    holder_word_at_ = now_();
    lease = agent_epoch_ < 0 || leased_for_ != epoch;
  }
  if (lease) {
    if (auto leased = Lease(); !leased) return leased;
  }
  core::Status armed = Upload(plan);
  bool held = false;
  {
    const std::lock_guard lock(mutex_);
    held = agent_epoch_ >= 0;
  }
  if (!armed && armed.error().code == core::ErrorCode::kStale && !held) {
    // Our lease ran out between two runs: once more from the start.
    if (auto leased = Lease(); !leased) return leased;
    armed = Upload(plan);
  }
  if (!armed) return armed;
  const std::lock_guard lock(mutex_);
  next_seq_ = seen_end_seq_ = next_index_ = 0;
  early_.clear();
  queue_.Reopen();
  run_state_ = RigState::kArmed;
  return core::Done{};
}

core::Status RemoteRig::Start(Epoch epoch) {
  const std::lock_guard control(control_mutex_);
  Message message;
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = CheckLocalEpoch(epoch); !fresh) return fresh;
    if (run_state_ != RigState::kArmed) {
      return core::Error{
          .code = core::ErrorCode::kConflict, .message = "the rig is not armed", .field = {}};
    }
    message = NewCommand("start");
    holder_word_at_ = now_();
    run_state_ = RigState::kRunning;  // its first words may come before the answer
  }
  const core::Result<Reply> reply = Ask(std::move(message));
  if (reply) return core::Done{};
  const std::lock_guard lock(mutex_);
  // Without an answer the rig may be running: its watchdog or our stream will tell.
  if (reply.error().code != core::ErrorCode::kUnavailable) run_state_ = RigState::kIdle;
  return reply.error();
}

core::Status RemoteRig::Command(Epoch epoch, const RigCommand& command) {
  Message message;
  bool lease = false;
  {
    const std::lock_guard lock(mutex_);
    if (auto fresh = CheckLocalEpoch(epoch); !fresh) return fresh;
    holder_word_at_ = now_();
    lease = agent_epoch_ < 0 && run_state_ == RigState::kIdle &&
            command.kind != RigCommand::Kind::kSetComponent;
  }
  if (lease) {
    const std::lock_guard control(control_mutex_);
    if (auto leased = Lease(); !leased) return leased;
  }
  {
    const std::lock_guard lock(mutex_);
    message = NewCommand(command.kind == RigCommand::Kind::kSetComponent ? "set"
                         : command.kind == RigCommand::Kind::kClearTrip  ? "clear"
                                                                         : "nominal");
    message.component = core::Name(command.component);
    message.value = command.value;
  }
  const core::Result<Reply> reply = Ask(std::move(message));
  if (!reply) return reply.error();
  return core::Done{};
}

void RemoteRig::KeepAlive(Epoch epoch) {
  const std::lock_guard lock(mutex_);
  if (CheckLocalEpoch(epoch)) holder_word_at_ = now_();
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
  bool leased = false;
  {
    const std::lock_guard lock(mutex_);
    if (epoch <= local_epoch_) return;
    local_epoch_ = epoch;
    leased = agent_epoch_ >= 0;
  }
  SafeStop("the lease was revoked");
  if (!leased) return;
  // The agent's fence rises as well: what is still on its way from before is refused there.
  const std::lock_guard control(control_mutex_);
  (void)Lease();
}

void RemoteRig::SafeStop(std::string_view reason) {
  Message message;
  {
    const std::lock_guard lock(mutex_);
    if (run_state_ == RigState::kArmed) {
      run_state_ = RigState::kIdle;
      queue_.Close();
    }
    if (agent_epoch_ < 0) return;
    message = NewCommand("stop");
    message.text = std::string(reason);
  }
  // A rig that cannot be reached stops by its own watchdog; its last words come with the refill.
  if (!Ask(std::move(message))) return;
  std::unique_lock lock(mutex_);
  answered_.wait_for(lock, settings_.give_up, [this] { return run_state_ != RigState::kRunning; });
}

SelfTestReport RemoteRig::SelfTest() {
  const std::lock_guard control(control_mutex_);
  SelfTestReport report;
  Message message;
  bool lease = false;
  {
    const std::lock_guard lock(mutex_);
    LAB_CHECK(run_state_ == RigState::kIdle, Name(run_state_));
    lease = agent_epoch_ < 0;
  }
  if (lease && !Lease()) return report;
  {
    const std::lock_guard lock(mutex_);
    message = NewCommand("self_test");
    holder_word_at_ = now_();
  }
  const core::Result<Reply> reply = Ask(std::move(message));
  if (!reply) return report;
  report.ok = reply.value().ok != 0;
  for (const faultlab_msgs::rig_position_t& position : reply.value().positions) {
    report.positions.push_back(
        {.component = core::ParseComponent(position.component).value_or(core::Component::kR1),
         .value = position.value,
         .line = position.line,
         .ok = position.ok != 0,
         .text = position.text});
  }
  return report;
}

// ---- what the bus says --------------------------------------------------------------------------

void RemoteRig::OnAnnounce(MessageBus::Bytes bytes) {
  // Without its key a rig can be watched, but not believed.
  std::optional<faultlab_msgs::rig_announce_t> said =
      settings_.key ? Verified<faultlab_msgs::rig_announce_t>(bytes, *settings_.key)
                    : FromBytes<faultlab_msgs::rig_announce_t>(bytes.data(), bytes.size());
  if (!said || said->rig != id_) return;
  const std::lock_guard lock(mutex_);
  // An old announcement of this or another start is no word of life.
  if (announced_ && (said->boot == announced_->boot ? said->seq <= announced_->seq
                                                    : said->sent_ns <= announced_->sent_ns)) {
    return;
  }
  if (said->boot != boot_) {
    boot_ = said->boot;
    agent_epoch_ = -1;
    if (run_state_ == RigState::kRunning || run_state_ == RigState::kArmed) {
      EndRun("the agent started anew");
    }
  }
  heard_at_ = now_();
  if (!described_) {
    described_ = true;  // fixed while the rig lives: readers hold a reference
    description_.rig_class = said->rig_class;
    description_.profile = said->profile;
    description_.has_ua = said->has_ua != 0;
    description_.has_ia = said->has_ia != 0;
    description_.has_n = said->has_n != 0;
    description_.any_value = said->any_value != 0;
    description_.motor_faults = said->motor_faults != 0;
    description_.amplifier_mode =
        said->current_mode ? core::AmplifierMode::kCurrent : core::AmplifierMode::kVoltage;
    description_.amplifier_quadrants =
        said->four_quadrants ? core::Quadrants::kFour : core::Quadrants::kTwo;
    description_.uc_v_min = said->uc_min_v;
    description_.uc_v_max = said->uc_max_v;
    description_.delta_s = said->delta_s;
  }
  if (run_state_ == RigState::kRunning && said->run == run_) {
    seen_end_seq_ = std::max(seen_end_seq_, said->run_next_seq);
  }
  announced_ = std::move(said);
}

void RemoteRig::OnReply(MessageBus::Bytes bytes) {
  if (!settings_.key) return;
  std::optional<Reply> reply = Verified<Reply>(bytes, *settings_.key);
  if (!reply || reply->rig != id_ || reply->holder != settings_.holder) return;
  const std::int64_t now_ns = unix_ns_();
  const std::lock_guard lock(mutex_);
  if (reply->boot != boot_) return;
  heard_at_ = now_();
  const double round_trip_s = static_cast<double>((now_ns - reply->command_sent_ns) -
                                                  (reply->sent_ns - reply->received_ns)) *
                              1e-9;
  // The quickest exchange tells the offset best; old ones fade as clocks drift.
  if (!offset_s_ || round_trip_s <= round_trip_s_ * 1.5) {
    offset_s_ = static_cast<double>((reply->received_ns - reply->command_sent_ns) +
                                    (reply->sent_ns - now_ns)) *
                0.5e-9;
    round_trip_s_ = round_trip_s;
  }
  const auto waiting = waiting_.find(reply->request);
  if (waiting == waiting_.end()) {
    const bool lease_gone = !reply->ok && (reply->field == "holder" || reply->field == "epoch");
    if (lease_gone && reply->epoch > agent_epoch_) agent_epoch_ = -1;
    return;
  }
  waiting->second = std::move(*reply);
  answered_.notify_all();
}

void RemoteRig::OnStream(MessageBus::Bytes bytes) {
  if (!settings_.key) return;
  const std::optional<faultlab_msgs::rig_stream_t> stream =
      Verified<faultlab_msgs::rig_stream_t>(bytes, *settings_.key);
  if (!stream || stream->rig != id_) return;
  const std::lock_guard lock(mutex_);
  if (stream->boot != boot_) return;
  heard_at_ = now_();
  if (run_state_ != RigState::kRunning || stream->run != run_) return;
  const std::int64_t end = stream->first_seq + stream->count;
  const bool refill = end <= seen_end_seq_;
  seen_end_seq_ = std::max(seen_end_seq_, end);
  for (std::int64_t seq = std::max(stream->first_seq, next_seq_); seq < end; ++seq) {
    const auto& item = stream->items[static_cast<std::size_t>(seq - stream->first_seq)];
    if (early_.emplace(seq, ToMessage(item)).second && refill) ++refilled_;
  }
  if (stream->oldest_seq > next_seq_) {
    // Gone from the ring: the recording says so.
    const auto first = early_.lower_bound(stream->oldest_seq);
    queue_.PushLast(RigEvent{.kind = RigEventKind::kGap,
                             .index = next_index_,
                             .value = static_cast<double>(stream->oldest_seq - next_seq_),
                             .text = "lost on the way and no longer in the agent's ring"});
    early_.erase(early_.begin(), first);
    next_seq_ = stream->oldest_seq;
  }
  DeliverInOrder();
}

void RemoteRig::DeliverInOrder() {
  auto next = early_.begin();
  while (next != early_.end() && next->first == next_seq_) {
    const bool last = EndsRun(next->second);
    if (const auto* sample = std::get_if<core::Sample>(&next->second)) {
      next_index_ = sample->index + 1;
    }
    if (const auto* event = std::get_if<RigEvent>(&next->second)) {
      if (event->kind == RigEventKind::kTrip) announced_->health = event->text;
    }
    if (last) {
      RigMessage message = std::move(next->second);
      EndRun(std::move(message));
      return;
    }
    if (!queue_.TryPush(std::move(next->second))) {
      Message stop = NewCommand("stop");
      stop.request = next_request_++;
      Send(stop);
      EndRun("queue full: nobody reads the samples");
      return;
    }
    next = early_.erase(next);
    ++next_seq_;
  }
}

/// Call with mutex_ held.
void RemoteRig::EndRun(const std::string& reason) {
  EndRun(RigEvent{.kind = RigEventKind::kStopped, .index = next_index_, .text = reason});
}

/// Call with mutex_ held.
void RemoteRig::EndRun(RigMessage last) {
  early_.clear();
  queue_.PushLast(std::move(last));
  queue_.Close();
  run_state_ = RigState::kIdle;
  // The next announcement will say so, too.
  if (announced_)
    announced_->state = Name(announced_->health.empty() ? RigState::kIdle : RigState::kTripped);
  answered_.notify_all();
}

/// Call with mutex_ held.
void RemoteRig::AskRefill() {
  const Nanoseconds now = now_();
  if (refill_asked_at_.count() >= 0 && now - refill_asked_at_ < kRefillEvery) return;
  refill_asked_at_ = now;
  // Each hole by itself: what lies between them is here already.
  std::int64_t from = next_seq_;
  auto known = early_.begin();
  for (int hole = 0; hole < kHolesAtOnce && from < seen_end_seq_; ++hole) {
    Message message = NewCommand("refill");
    message.request = next_request_++;
    message.from = from;
    message.to = known == early_.end() ? seen_end_seq_ : known->first;
    Send(message);
    from = message.to;
    while (known != early_.end() && known->first == from) {
      ++known;
      ++from;
    }
  }
}

void RemoteRig::Poll() {
  const std::lock_guard lock(mutex_);
  if (!settings_.key) return;
  const Nanoseconds now = now_();
  const bool running = run_state_ == RigState::kRunning;
  if (running && now - heard_at_ > settings_.lost_for_good) {
    EndRun("the rig was lost");
    return;
  }
  // A refill needs no lease: after a long cut ours is gone, but the recording is to be whole.
  if (running && next_seq_ < seen_end_seq_) AskRefill();
  if (agent_epoch_ < 0) return;
  const bool wanted = running ? readers_ > 0 || now - holder_word_at_ <= kHolderSilent
                              : now - holder_word_at_ <= settings_.lease_linger;
  if (!running && !wanted) {
    Message release = NewCommand("release");
    release.request = next_request_++;
    Send(release);
    agent_epoch_ = -1;
    if (run_state_ == RigState::kArmed) {
      run_state_ = RigState::kIdle;
      queue_.Close();
    }
  } else if (wanted && (alive_sent_at_.count() < 0 || now - alive_sent_at_ >= kAliveEvery)) {
    alive_sent_at_ = now;
    Message alive = NewCommand("alive");
    alive.request = next_request_++;
    Send(alive);
  }
}

}  // namespace faultlab::hardware
