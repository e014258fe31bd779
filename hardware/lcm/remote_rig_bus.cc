// What the bus says of a far rig, and what must be done about it again and again.
#include <algorithm>
#include <utility>

#include "faultlab_msgs/rig_bench_t.hpp"
#include "faultlab_msgs/rig_stream_t.hpp"
#include "hardware/bench/benches.h"
#include "hardware/holder_silence.h"
#include "hardware/lcm/remote_rig.h"
#include "hardware/lcm/rig_codec.h"
#include "hardware/lcm/sealed_message.h"

namespace faultlab::hardware {
namespace {

constexpr Nanoseconds kAliveEvery = std::chrono::milliseconds(100);
/// Between runs: the agent's lease is 5 s long.
constexpr Nanoseconds kOursEvery = std::chrono::seconds(1);
constexpr Nanoseconds kRefillEvery = std::chrono::milliseconds(100);
constexpr std::size_t kHolesAtOnce = 32;

bool EndsRun(const RigMessage& message) {
  const auto* event = std::get_if<RigEvent>(&message);
  return event != nullptr &&
         (event->kind == RigEventKind::kFinished || event->kind == RigEventKind::kStopped);
}

}  // namespace

bool RemoteRig::OnAnnounce(MessageBus::Bytes bytes) {
  std::optional<faultlab_msgs::rig_announce_t> said = ReadAnnouncement(bytes, id_, settings_.key);
  if (!said) {
    const bool foreign = IsForeignProtocol(bytes, id_, settings_.key);
    const std::lock_guard lock(mutex_);
    foreign_protocol_ = foreign;
    other_key_ = !foreign;
    return foreign;
  }
  const std::lock_guard lock(mutex_);
  // An old announcement of this or another start is no word of life.
  if (announced_ && (said->boot == announced_->boot ? said->seq <= announced_->seq
                                                    : said->sent_ns <= announced_->sent_ns)) {
    return true;
  }
  if (!announced_ || said->boot != announced_->boot) {
    line_.SetBoot(said->boot);
    if (run_state_ == RigState::kRunning || run_state_ == RigState::kArmed) {
      EndRun("the agent started anew");
    }
  }
  heard_at_ = now_();
  foreign_protocol_ = other_key_ = false;
  if (!described_) TakeDescription(*said);
  if (run_state_ == RigState::kRunning && said->run == assembly_.run()) {
    assembly_.Expect(said->run_next_seq);
  }
  const bool superseded = run_state_ == RigState::kRunning && said->run > assembly_.run();
  announced_ = std::move(said);
  if (superseded) EndRun("the rig has begun another run");
  return true;
}

void RemoteRig::GiveUp(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  if (run_state_ == RigState::kRunning || run_state_ == RigState::kArmed) EndRun(reason);
}

/// Call with mutex_ held. What is said of the rig stays while it lives: readers hold a reference.
void RemoteRig::TakeDescription(const faultlab_msgs::rig_announce_t& said) {
  const core::Bench* bench = FindKeptBench(said.bench);
  if (bench == nullptr) return;
  description_.bench = bench;
  description_.has_um = bench->um.exists;
  Decode(said, description_);
  described_ = true;
}

void RemoteRig::OnBench(MessageBus::Bytes bytes) {
  const auto said =
      Opened<faultlab_msgs::rig_bench_t>(bytes, BenchChannel(id_), id_, settings_.key);
  if (!said) return;
  const auto kept = KeepBench(said->text, "bench of " + id_);
  const std::lock_guard lock(mutex_);
  bench_refusal_ = kept.ok() ? "" : kept.error().message;
  if (!described_ && announced_) TakeDescription(*announced_);
}

bool RemoteRig::IsDescribed() const {
  const std::lock_guard lock(mutex_);
  return described_;
}

bool RemoteRig::AnnouncesAnotherBench() const {
  const std::lock_guard lock(mutex_);
  return described_ && announced_ && announced_->bench != description_.bench->id;
}

std::string RemoteRig::bench_refusal() const {
  const std::lock_guard lock(mutex_);
  return bench_refusal_;
}

void RemoteRig::OnReply(MessageBus::Bytes bytes) {
  if (!line_.OnReply(bytes)) return;
  const std::lock_guard lock(mutex_);
  heard_at_ = now_();
}

void RemoteRig::OnStream(MessageBus::Bytes bytes) {
  const auto piece =
      Opened<faultlab_msgs::rig_stream_t>(bytes, stream_channel_, id_, settings_.key);
  if (!piece) return;
  const std::lock_guard lock(mutex_);
  if (!announced_ || piece->boot != announced_->boot) return;
  heard_at_ = now_();
  if (run_state_ != RigState::kRunning) return;
  std::vector<RigMessage> messages;
  assembly_.Take(*piece, messages);
  Deliver(std::move(messages));
}

/// Call with mutex_ held.
void RemoteRig::Deliver(std::vector<RigMessage> messages) {
  for (RigMessage& message : messages) {
    if (EndsRun(message)) {
      EndRun(std::move(message));
      return;
    }
    if (const auto* event = std::get_if<RigEvent>(&message)) FollowTrip(*event);
    if (!queue_.TryPush(std::move(message))) {
      if (const auto epoch = line_.leased()) line_.Tell(line_.NewCommand("stop", *epoch));
      EndRun("queue full: nobody reads the samples");
      return;
    }
  }
}

/// A trip is known before the next announcement tells its limit and time, too.
void RemoteRig::FollowTrip(const RigEvent& event) {
  if (event.kind != RigEventKind::kTrip || !announced_) return;
  const std::size_t colon = event.text.find(": ");
  const bool named = colon != std::string::npos;
  Encode(Trip{.name = event.text.substr(0, colon),
              .value = event.value,
              .index = event.index,
              .text = named ? event.text.substr(colon + 2) : event.text},
         *announced_);
}

/// Call with mutex_ held.
void RemoteRig::EndRun(const std::string& reason) {
  EndRun(RigEvent{.kind = RigEventKind::kStopped, .index = assembly_.next_index(), .text = reason});
}

/// Call with mutex_ held.
void RemoteRig::EndRun(RigMessage last) {
  queue_.PushLast(std::move(last));
  queue_.Close();
  run_state_ = RigState::kIdle;
  if (announced_) {
    // The next announcement will say so, too.
    announced_->state = Name(announced_->trip.empty() ? RigState::kIdle : RigState::kTripped);
  }
  run_ended_.notify_all();
}

void RemoteRig::Poll() {
  const std::lock_guard lock(mutex_);
  line_.Poll();
  const Nanoseconds now = now_();
  const bool running = run_state_ == RigState::kRunning;
  if (running && now - heard_at_ > settings_.lost_for_good) {
    EndRun("the rig was lost");
    return;
  }
  // A refill needs no lease: after a long cut ours is gone, but the recording is to be whole.
  if (running && !assembly_.whole() &&
      (refill_asked_at_.count() < 0 || now - refill_asked_at_ >= kRefillEvery)) {
    refill_asked_at_ = now;
    for (const ReorderBuffer::Hole& hole : assembly_.Holes(kHolesAtOnce)) {
      AgentClient::Message message = line_.NewCommand("refill");
      message.from = hole.from;
      message.to = hole.to;
      line_.Tell(std::move(message));
    }
  }
  const std::optional<Epoch> leased = line_.leased();
  if (!leased) return;
  // A run whose holder is silent is left to the agent's watchdog.
  const bool wanted = !running || readers_ > 0 || now - holder_word_at_ <= kHolderSilence;
  const Nanoseconds every = running ? kAliveEvery : kOursEvery;
  if (wanted && (alive_sent_at_.count() < 0 || now - alive_sent_at_ >= every)) {
    alive_sent_at_ = now;
    line_.Tell(line_.NewCommand("alive", *leased));
  }
}

}  // namespace faultlab::hardware
