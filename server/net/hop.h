#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "server/net/http.h"
#include "server/wall_time.h"

namespace faultlab::server {

inline constexpr std::string_view kHopHeader = "X-Faultlab-Hop";

/// What a server says of a request that it passes on to another server of its lab. Nothing else is
/// believed because of it: who asks is proved to the receiver by the request's own credentials.
struct Hop {
  std::string client;  ///< address of who asked the first server
  bool https = false;  ///< they came by https
};

/// Seals hops with a secret that the servers of one lab share:
///
///   X-Faultlab-Hop: <ms since 1970> <http|https> <hex HMAC-SHA256> <client>
///
/// The seal covers the receiver's name, method and target as well and holds for `kHopLife`, so it
/// opens nothing else. Immutable, any thread.
class HopSeal {
 public:
  /// @param self  this server's name among those that share `secret`
  HopSeal(std::string secret, std::string self)
      : secret_(std::move(secret)), self_(std::move(self)) {}

  /// The header's value for a request that `receiver` shall get.
  std::string Seal(const Hop& hop,
                   std::string_view receiver,
                   const HttpRequest& request,
                   WallTime now) const;
  /// nullopt unless one of these servers made `value` for this request to this server just now.
  std::optional<Hop> Open(std::string_view value, const HttpRequest& request, WallTime now) const;

 private:
  std::string secret_;
  std::string self_;
};

}  // namespace faultlab::server
