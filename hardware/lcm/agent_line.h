#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "core/types/result.h"
#include "faultlab_msgs/rig_command_t.hpp"
#include "faultlab_msgs/rig_reply_t.hpp"
#include "hardware/clock.h"
#include "hardware/lcm/clock_offset.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/rig_key.h"

namespace faultlab::hardware {

struct AgentLineSettings {
  std::string rig;
  std::string holder;         ///< our name, unique among all servers and starts
  std::optional<RigKey> key;  ///< none: nothing can be said
  Nanoseconds retry = std::chrono::milliseconds(100);
  Nanoseconds give_up = std::chrono::seconds(2);  ///< of one request
};

/// What we say to one agent: signed, counted, under our lease. Thread-safe; Ask waits for the bus
/// thread, which calls OnReply.
class AgentLine {
 public:
  using Message = faultlab_msgs::rig_command_t;
  using Reply = faultlab_msgs::rig_reply_t;

  AgentLine(AgentLineSettings settings,
            std::shared_ptr<MessageBus> bus,
            std::function<Nanoseconds()> now,
            std::function<std::int64_t()> unix_ns);

  bool key_known() const { return settings_.key.has_value(); }

  /// Another start of the agent: it knows no lease of ours.
  void SetBoot(std::int64_t boot);
  /// A new lease; its epoch goes into every command from now on.
  core::Status Lease();
  bool leased() const;
  /// The lease is over, without a word.
  void DropLease();

  Message NewCommand(const std::string& action) const;
  /// No answer is waited for.
  void Tell(Message message);
  /// Repeats itself until the answer comes; kUnavailable when none does. An answer that is not ok
  /// is an Error, but for one with a list of what is missing or of relay positions.
  core::Result<Reply> Ask(Message message);

  /// @returns true if it was a word to us, checked with the key.
  bool OnReply(MessageBus::Bytes bytes);

  ClockOffset clock_offset() const;

 private:
  void Send(Message& message);

  const AgentLineSettings settings_;
  const std::shared_ptr<MessageBus> bus_;
  const std::function<Nanoseconds()> now_;
  const std::function<std::int64_t()> unix_ns_;

  mutable std::mutex mutex_;
  std::condition_variable answered_;
  std::int64_t boot_ = 0;
  std::int64_t epoch_ = -1;  ///< of our lease at the agent, -1 = none
  std::int64_t counter_ = 0;
  std::int64_t next_request_ = 0;
  std::map<std::int64_t, std::optional<Reply>> waiting_;
  ClockOffset clock_offset_;
};

}  // namespace faultlab::hardware
