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
#include "hardware/rig.h"

namespace faultlab::hardware {

struct AgentClientSettings {
  std::string rig;
  std::string holder;  ///< our name, HolderName; its member is unique to this start
  RigKey key{};
  Nanoseconds retry = std::chrono::milliseconds(100);
  Nanoseconds give_up = std::chrono::seconds(2);  ///< of one request
};

/// What we say to one agent: sealed, counted, each word with the epoch of the lease that it is said
/// under. Nothing below the fence leaves. Once leased, the rig stays ours while we live: a lease
/// that the agent does not know any more is asked for again. Thread-safe; Ask waits for the bus
/// thread, which calls OnReply and Poll.
class AgentClient {
 public:
  using Message = faultlab_msgs::rig_command_t;
  using Reply = faultlab_msgs::rig_reply_t;

  AgentClient(AgentClientSettings settings,
              std::shared_ptr<MessageBus> bus,
              std::function<Nanoseconds()> now,
              std::function<std::int64_t()> unix_ns);

  /// Another start of the agent: it knows no lease of ours.
  void SetBoot(std::int64_t boot);
  /// From now on nothing of an older epoch leaves, and whoever waits for its answer gets kStale.
  /// The agent is told by asking for the lease of this epoch, again with each Poll until it
  /// answers. Waits for nothing. @returns false when the epoch is not newer: nothing has changed.
  bool Fence(Epoch epoch);
  /// kStale below the fence.
  core::Status Check(Epoch epoch) const;
  /// Asks for the lease of this epoch, which raises the fence.
  core::Status Lease(Epoch epoch);
  /// The epoch of the lease that the agent has given us.
  std::optional<Epoch> leased() const;

  Message NewCommand(const std::string& action, Epoch epoch) const;
  /// What needs no lease (reading).
  Message NewCommand(const std::string& action) const;
  /// No answer is waited for.
  void Tell(Message message);
  /// Repeats itself until the answer comes; kUnavailable when none does. An answer that is not ok
  /// is an Error, but for one with a list of what is missing or of relay positions.
  core::Result<Reply> Ask(Message message);
  /// Asks again for the lease that has not been answered. Every few milliseconds.
  void Poll();

  /// @returns true if it was a word to us, sealed with the key.
  bool OnReply(MessageBus::Bytes bytes);

  ClockOffset clock_offset() const;

 private:
  struct OwedLease {
    std::int64_t epoch;
    std::int64_t request;
    Nanoseconds said_at{-1};
  };
  bool Send(Message& message);
  core::Status CheckNumber(std::int64_t epoch) const;
  Message NewMessage(const std::string& action, std::int64_t epoch) const;
  void Owe(std::int64_t epoch);
  void SayOwed();
  void Granted(std::int64_t epoch, std::int64_t request);
  void FollowLoss(const Reply& reply);

  const AgentClientSettings settings_;
  const std::string command_channel_;
  const std::string reply_channel_;
  const std::shared_ptr<MessageBus> bus_;
  const std::function<Nanoseconds()> now_;
  const std::function<std::int64_t()> unix_ns_;

  mutable std::mutex mutex_;
  std::condition_variable answered_;
  std::int64_t boot_ = 0;
  std::int64_t fence_ = 0;
  std::int64_t epoch_ = -1;          ///< of our lease at the agent, -1 = none
  std::int64_t lease_request_ = -1;  ///< that got it: refusals of earlier ones say nothing of it
  std::optional<OwedLease> owed_;    ///< asked for without anybody who waits
  std::int64_t counter_ = 0;
  std::int64_t next_request_ = 0;
  std::map<std::int64_t, std::optional<Reply>> waiting_;
  ClockOffset clock_offset_;
};

}  // namespace faultlab::hardware
