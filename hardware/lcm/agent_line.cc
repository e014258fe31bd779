#include "hardware/lcm/agent_line.h"

#include <utility>

#include "core/types/check.h"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/rig_name.h"

namespace faultlab::hardware {
namespace {

bool SaysLeaseIsGone(const faultlab_msgs::rig_reply_t& reply) {
  return reply.ok == 0 && (reply.field == "holder" || reply.field == "epoch");
}

}  // namespace

AgentLine::AgentLine(AgentLineSettings settings,
                     std::shared_ptr<MessageBus> bus,
                     std::function<Nanoseconds()> now,
                     std::function<std::int64_t()> unix_ns)
    : settings_(std::move(settings)),
      bus_(std::move(bus)),
      now_(std::move(now)),
      unix_ns_(std::move(unix_ns)) {
  LAB_CHECK(IsRigName(settings_.rig), settings_.rig);
}

void AgentLine::SetBoot(std::int64_t boot) {
  const std::lock_guard lock(mutex_);
  boot_ = boot;
  epoch_ = -1;
}

bool AgentLine::leased() const {
  const std::lock_guard lock(mutex_);
  return epoch_ >= 0;
}

void AgentLine::DropLease() {
  const std::lock_guard lock(mutex_);
  epoch_ = -1;
}

ClockOffset AgentLine::clock_offset() const {
  const std::lock_guard lock(mutex_);
  return clock_offset_;
}

AgentLine::Message AgentLine::NewCommand(const std::string& action) const {
  Message message{};
  message.rig = settings_.rig;
  message.holder = settings_.holder;
  message.action = action;
  const std::lock_guard lock(mutex_);
  message.boot = boot_;
  message.epoch = epoch_;
  return message;
}

/// Call with mutex_ held: counters leave in their order.
void AgentLine::Send(Message& message) {
  message.counter = ++counter_;
  message.sent_ns = unix_ns_();
  bus_->Publish(CommandChannel(settings_.rig), SignedBytes(message, *settings_.key));
}

void AgentLine::Tell(Message message) {
  if (!settings_.key) return;
  const std::lock_guard lock(mutex_);
  message.request = next_request_++;
  Send(message);
}

core::Result<AgentLine::Reply> AgentLine::Ask(Message message) {
  if (!settings_.key) {
    return core::Error{.code = core::ErrorCode::kForbidden,
                       .message = "the key of rig " + settings_.rig + " is not here: copy " +
                                  settings_.rig + ".key from the agent's key folder",
                       .field = "keys"};
  }
  std::unique_lock lock(mutex_);
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
      if (SaysLeaseIsGone(answer)) epoch_ = -1;
      if (answer.ok || answer.position_count > 0 || answer.missing_count > 0) return answer;
      return core::Error{.code = static_cast<core::ErrorCode>(answer.code),
                         .message = answer.message,
                         .field = answer.field};
    }
    if (now_() >= give_up_at) {
      waiting_.erase(message.request);
      return core::Error{.code = core::ErrorCode::kUnavailable,
                         .message = "rig " + settings_.rig + " does not answer",
                         .field = {}};
    }
  }
}

core::Status AgentLine::Lease() {
  const core::Result<Reply> reply = Ask(NewCommand("lease"));
  if (!reply) return reply.error();
  const std::lock_guard lock(mutex_);
  epoch_ = reply.value().epoch;
  return core::Done{};
}

bool AgentLine::OnReply(MessageBus::Bytes bytes) {
  if (!settings_.key) return false;
  std::optional<Reply> reply = Verified<Reply>(bytes, *settings_.key);
  if (!reply || reply->rig != settings_.rig || reply->holder != settings_.holder) return false;
  const std::int64_t now_ns = unix_ns_();
  const std::lock_guard lock(mutex_);
  if (reply->boot != boot_) return false;
  clock_offset_.Exchange(reply->command_sent_ns, reply->received_ns, reply->sent_ns, now_ns);
  const auto waiting = waiting_.find(reply->request);
  if (waiting == waiting_.end()) {
    if (SaysLeaseIsGone(*reply) && reply->epoch > epoch_) epoch_ = -1;
    return true;
  }
  waiting->second = std::move(*reply);
  answered_.notify_all();
  return true;
}

}  // namespace faultlab::hardware
