#pragma once

#include <string_view>

#include "core/types/result.h"
#include "server/notify/attempt.h"
#include "server/notify/message.h"
#include "server/wall_time.h"

namespace faultlab::server::notify {

/// Receivers of the outbox besides webhooks. Called by the dispatcher's threads, and may block.
class Channel {
 public:
  virtual ~Channel() = default;
  /// Of Message::channel: "lti:".
  virtual std::string_view prefix() const = 0;
  /// Else another server of the database sends: nothing of it is claimed here. For a channel whose
  /// name is its prefix.
  virtual bool is_on() const { return true; }
  /// Puts what is new into the outbox. @returns whether there was anything
  virtual core::Result<bool> Gather(WallTime now) = 0;
  virtual Attempt Send(const Message& message) = 0;
};

}  // namespace faultlab::server::notify
