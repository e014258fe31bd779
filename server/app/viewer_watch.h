#pragma once

#include <optional>

#include "server/auth/accounts.h"
#include "server/clock.h"
#include "server/repeated.h"
#include "server/stream/stream_hub.h"
#include "server/stream/stream_tokens.h"

namespace faultlab::server {

/// Closes the WebSockets and codes of people whose right to them has ended: at once if this process
/// ended it, within two seconds if another server, `faultlab admin` or a time limit did.
class ViewerWatch {
 public:
  /// All must outlive this object. Becomes the listener of Accounts.
  ViewerWatch(Accounts& accounts, StreamHub& hub, StreamTokens& tokens, const Clock& clock);
  ~ViewerWatch();
  ViewerWatch(const ViewerWatch&) = delete;
  ViewerWatch& operator=(const ViewerWatch&) = delete;

 private:
  void End(const Revocation& revocation);
  void Look();
  /// According to the database, which other servers change too.
  bool MayWatch(const ViewerOwner& owner);

  Accounts& accounts_;
  StreamHub& hub_;
  StreamTokens& tokens_;
  const Clock& clock_;
  std::optional<Repeated> looks_;
};

}  // namespace faultlab::server
