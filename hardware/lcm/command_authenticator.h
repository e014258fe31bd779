#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>

#include "faultlab_msgs/rig_command_t.hpp"
#include "faultlab_msgs/rig_reply_t.hpp"
#include "hardware/lcm/channels.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/rig_key.h"

namespace faultlab::hardware {

/// Who gets in: a command must be sealed with the rig's key, name this start of the agent, and
/// count above the last of its holder. Whether the holder may do what it asks is the agent's to
/// say.
class CommandAuthenticator {
 public:
  using Command = faultlab_msgs::rig_command_t;
  using Reply = faultlab_msgs::rig_reply_t;
  enum class Verdict { kNew, kForged, kReplayed, kRepeated };

  CommandAuthenticator(std::string rig, RigKey key, std::int64_t boot)
      : rig_(std::move(rig)), channel_(CommandChannel(rig_)), key_(key), boot_(boot) {}

  /// kNew and kRepeated fill `command`. kRepeated: the answer was lost, see Remembered.
  Verdict Check(MessageBus::Bytes bytes, Command& command);
  /// The answer that a repeated request got: it must not act twice.
  const Reply* Remembered(const Command& command) const;
  void Remember(Reply reply);

 private:
  const std::string rig_;
  const std::string channel_;
  const RigKey key_;
  const std::int64_t boot_;
  std::map<std::string, std::int64_t> counters_;  ///< last of each holder
  std::deque<Reply> replies_;                     ///< the last few
};

}  // namespace faultlab::hardware
