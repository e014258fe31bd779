#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "server/net/http.h"
#include "server/wall_time.h"

namespace faultlab::server {

inline constexpr std::string_view kHopHeader = "X-Faultlab-Hop";

/// What a server states about a request that it passes on to another server of its lab. Only these
/// facts are trusted; the request's own credentials prove the user to the receiver.
struct ForwardedRequest {
  std::string client;       ///< address of the client of the first server
  bool https = false;       ///< the client used https
  std::string body_hash{};  ///< BodyHash of what was passed on
};
/// SHA-256 as hex.
std::string BodyHash(std::string_view body);

/// Seals hops with a secret that the servers of one lab share:
///
///   X-Faultlab-Hop: <ms since 1970> <http|https> <number> <body hash> <hex HMAC-SHA256> <client>
///
/// The seal also covers the receiver's name, method and target, is valid for `kForwardingLife` and
/// opens once, so it cannot be used for anything else, nor again. Thread-safe.
class ForwardingSeal {
 public:
  /// @param self  this server's name among those that share `secret`
  ForwardingSeal(std::string secret, std::string self)
      : secret_(std::move(secret)), self_(std::move(self)) {}

  /// The header's value for a request to `receiver`; `hop.body_hash` is not read, but made here.
  std::string Seal(const ForwardedRequest& hop,
                   std::string_view receiver,
                   const HttpRequest& request,
                   WallTime now) const;
  /// nullopt unless one of these servers made `value` for this request to this server within
  /// kForwardingLife, and it was not opened before. The body may not be there yet: who has it
  /// compares its hash.
  std::optional<ForwardedRequest> Open(std::string_view value,
                                       const HttpRequest& request,
                                       WallTime now) const;

 private:
  struct Opened {
    std::mutex mutex;
    WallTime turned{};
    std::set<std::string, std::less<>> newer;  ///< numbers since `turned`
    std::set<std::string, std::less<>> older;  ///< those of the turn before
  };

  std::string secret_;
  std::string self_;
  std::shared_ptr<Opened> opened_ = std::make_shared<Opened>();
};

}  // namespace faultlab::server
