#pragma once

#include <string>

#include "core/types/result.h"
#include "server/notify/attempt.h"
#include "server/notify/message.h"
#include "server/notify/webhooks.h"
#include "server/web_client/web_client.h"

namespace faultlab::server::notify {

/// Sends a message to a webhook: JSON by POST, signed as Standard Webhooks has it.
///
///   webhook-id, X-Faultlab-Delivery   Message::delivery
///   webhook-timestamp                 seconds, when it was sent
///   webhook-signature                 Sign()
///   {"type": kind, "timestamp": when it happened, "data": Message::about}
///
/// An answer 2xx takes it. Blocks: never on a network thread. Thread-safe.
class HookSender {
 public:
  /// @param insecure_local  webhooks may also be http:// in the local network
  /// @param ca_file  PEM; empty: the system's
  /// A webhook of a person reaches the internet alone, unless `insecure_local` lets all into the
  /// local network.
  explicit HookSender(bool insecure_local, const std::string& ca_file = "");

  /// kInvalid, reason webhook_url_wrong.
  core::Status CheckUrl(const std::string& url) const;
  Attempt Send(const Webhook& hook, const Message& message, WallTime now) const;

 private:
  const bool local_for_all_;
  const WebClient client_;
};

}  // namespace faultlab::server::notify
