#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/net/http.h"
#include "server/wall_time.h"

namespace faultlab::server {

inline constexpr std::string_view kHopHeader = "X-Faultlab-Hop";

/// What a server states about a request that it passes on to another server of its lab. Only these
/// facts are trusted; the request's own credentials prove the user to the receiver.
struct ForwardedRequest {
  std::string client;  ///< address of the client of the first server
  bool https = false;  ///< the client used https
};

/// Seals hops with a secret that the servers of one lab share:
///
///   X-Faultlab-Hop: <ms since 1970> <http|https> <hex HMAC-SHA256> <client>
///
/// The seal also covers the receiver's name, method and target, and is valid for `kForwardingLife`,
/// so it cannot be used for anything else. Immutable; any thread.
class ForwardingSeal {
 public:
  /// @param self  this server's name among those that share `secret`
  ForwardingSeal(std::string secret, std::string self)
      : secret_(std::move(secret)), self_(std::move(self)) {}

  /// The header's value for a request to `receiver`.
  std::string Seal(const ForwardedRequest& hop,
                   std::string_view receiver,
                   const HttpRequest& request,
                   WallTime now) const;
  /// nullopt unless one of these servers made `value` for this request to this server within
  /// kForwardingLife.
  std::optional<ForwardedRequest> Open(std::string_view value,
                                       const HttpRequest& request,
                                       WallTime now) const;

 private:
  std::string secret_;
  std::string self_;
};

}  // namespace faultlab::server
