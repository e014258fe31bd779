#include "hardware/lcm/agent_client.h"

#include <utility>

#include "core/types/check.h"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/rig_name.h"
#include "hardware/lcm/sealed_message.h"
#include "hardware/refusal.h"

namespace faultlab::hardware {
namespace {

/// A newer agent may have codes that this version does not know.
core::ErrorCode CodeOf(const faultlab_msgs::rig_reply_t& reply) {
  const bool known =
      reply.code >= 0 && reply.code <= static_cast<std::int8_t>(core::ErrorCode::kStale);
  return known ? static_cast<core::ErrorCode>(reply.code) : core::ErrorCode::kUnavailable;
}

bool SaysLeaseIsGone(const faultlab_msgs::rig_reply_t& reply) {
  return reply.ok == 0 && (reply.field == "holder" || reply.field == "epoch");
}

std::int64_t FenceNumber(Epoch epoch) {
  return static_cast<std::int64_t>(epoch);
}

}  // namespace

AgentClient::AgentClient(AgentClientSettings settings,
                         std::shared_ptr<MessageBus> bus,
                         std::function<Nanoseconds()> now,
                         std::function<std::int64_t()> unix_ns)
    : settings_(std::move(settings)),
      command_channel_(CommandChannel(settings_.rig)),
      reply_channel_(ReplyChannel(settings_.rig)),
      bus_(std::move(bus)),
      now_(std::move(now)),
      unix_ns_(std::move(unix_ns)) {
  LAB_CHECK(IsRigName(settings_.rig), settings_.rig);
}

void AgentClient::SetBoot(std::int64_t boot) {
  const std::lock_guard lock(mutex_);
  boot_ = boot;
  if (owed_) {
    owed_->said_at = Nanoseconds(-1);
  } else if (epoch_ >= 0) {
    Owe(epoch_);
  }
  epoch_ = -1;
}

/// Call with mutex_ held, as the five below.
core::Status AgentClient::CheckNumber(std::int64_t epoch) const {
  if (epoch >= fence_) return core::Done{};
  return StaleEpoch(epoch, fence_);
}

void AgentClient::Owe(std::int64_t epoch) {
  owed_ = OwedLease{.epoch = epoch, .request = next_request_++};
}

void AgentClient::SayOwed() {
  if (!owed_ || boot_ == 0) return;
  Message message = NewMessage("lease", owed_->epoch);
  message.request = owed_->request;
  owed_->said_at = now_();
  if (!Send(message)) owed_.reset();
}

void AgentClient::Granted(std::int64_t epoch, std::int64_t request) {
  epoch_ = epoch;
  lease_request_ = request;
  if (owed_ && owed_->epoch <= epoch) owed_.reset();
}

/// The agent knows no lease of ours any more, as after a long silence: it is asked for again.
void AgentClient::FollowLoss(const Reply& reply) {
  if (epoch_ < 0 || reply.request < lease_request_ || !SaysLeaseIsGone(reply)) return;
  if (!owed_) Owe(epoch_);
  epoch_ = -1;
}

bool AgentClient::Fence(Epoch epoch) {
  const std::lock_guard lock(mutex_);
  if (FenceNumber(epoch) <= fence_) return false;
  fence_ = FenceNumber(epoch);
  Owe(fence_);
  SayOwed();
  answered_.notify_all();
  return true;
}

core::Status AgentClient::Check(Epoch epoch) const {
  const std::lock_guard lock(mutex_);
  return CheckNumber(FenceNumber(epoch));
}

std::optional<Epoch> AgentClient::leased() const {
  const std::lock_guard lock(mutex_);
  if (epoch_ < 0) return std::nullopt;
  return Epoch{static_cast<std::uint64_t>(epoch_)};
}

void AgentClient::Poll() {
  const std::lock_guard lock(mutex_);
  if (!owed_) return;
  const bool due = owed_->said_at.count() < 0 || now_() - owed_->said_at >= settings_.retry;
  if (due) SayOwed();
}

ClockOffset AgentClient::clock_offset() const {
  const std::lock_guard lock(mutex_);
  return clock_offset_;
}

/// Call with mutex_ held.
AgentClient::Message AgentClient::NewMessage(const std::string& action, std::int64_t epoch) const {
  Message message{};
  message.rig = settings_.rig;
  message.boot = boot_;
  message.holder = settings_.holder;
  message.epoch = epoch;
  message.action = action;
  return message;
}

AgentClient::Message AgentClient::NewCommand(const std::string& action, Epoch epoch) const {
  const std::lock_guard lock(mutex_);
  return NewMessage(action, FenceNumber(epoch));
}

AgentClient::Message AgentClient::NewCommand(const std::string& action) const {
  const std::lock_guard lock(mutex_);
  return NewMessage(action, fence_);
}

/// Call with mutex_ held: counters leave in their order. @returns false below the fence.
bool AgentClient::Send(Message& message) {
  if (message.epoch < fence_) return false;
  message.counter = ++counter_;
  message.sent_ns = unix_ns_();
  bus_->Publish(command_channel_, Sealed(message, command_channel_, settings_.key));
  return true;
}

void AgentClient::Tell(Message message) {
  const std::lock_guard lock(mutex_);
  message.request = next_request_++;
  (void)Send(message);
}

core::Result<AgentClient::Reply> AgentClient::Ask(Message message) {
  std::unique_lock lock(mutex_);
  message.request = next_request_++;
  waiting_[message.request].reset();
  const Nanoseconds give_up_at = now_() + settings_.give_up;
  while (true) {
    if (!Send(message)) {
      waiting_.erase(message.request);
      return CheckNumber(message.epoch).error();
    }
    answered_.wait_for(lock, settings_.retry, [&] {
      return waiting_[message.request].has_value() || message.epoch < fence_;
    });
    if (std::optional<Reply>& reply = waiting_[message.request]) {
      Reply answer = std::move(*reply);
      waiting_.erase(message.request);
      FollowLoss(answer);
      if (answer.ok || answer.position_count > 0 || answer.missing_count > 0) return answer;
      return core::Error{.code = CodeOf(answer),
                         .message = ShownText(answer.message),
                         .field = ShownText(answer.field, 40)};
    }
    if (now_() >= give_up_at) {
      waiting_.erase(message.request);
      return core::Error{.code = core::ErrorCode::kUnavailable,
                         .message = "rig " + settings_.rig + " does not answer",
                         .field = {}};
    }
  }
}

core::Status AgentClient::Lease(Epoch epoch) {
  const std::int64_t number = FenceNumber(epoch);
  (void)Fence(epoch);
  const core::Result<Reply> reply = Ask(NewCommand("lease", epoch));
  const std::lock_guard lock(mutex_);
  if (!reply) {
    // The agent has ended what was before, or somebody else has the rig. Without an answer: who
    // knows; the next word to the agent tells.
    if (reply.error().field == kLeaseField) epoch_ = -1;
    return reply.error();
  }
  if (auto fresh = CheckNumber(number); !fresh) return fresh;
  Granted(number, reply.value().request);
  return core::Done{};
}

bool AgentClient::OnReply(MessageBus::Bytes bytes) {
  std::optional<Reply> reply = Opened<Reply>(bytes, reply_channel_, settings_.rig, settings_.key);
  if (!reply || reply->holder != settings_.holder) return false;
  const std::int64_t now_ns = unix_ns_();
  const std::lock_guard lock(mutex_);
  if (reply->boot != boot_) return false;
  clock_offset_.Exchange(reply->command_sent_ns, reply->received_ns, reply->sent_ns, now_ns);
  if (owed_ && reply->request == owed_->request) {
    if (reply->ok) {
      Granted(owed_->epoch, owed_->request);
    } else {
      epoch_ = -1;
      owed_.reset();  // the next user of the rig hears why
    }
    return true;
  }
  const auto waiting = waiting_.find(reply->request);
  if (waiting == waiting_.end()) {
    FollowLoss(*reply);
    return true;
  }
  waiting->second = std::move(*reply);
  answered_.notify_all();
  return true;
}

}  // namespace faultlab::hardware
