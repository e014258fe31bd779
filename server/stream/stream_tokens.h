#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "server/clock.h"
#include "server/stream/viewer_owner.h"

namespace faultlab::server {

inline constexpr std::chrono::seconds kStreamTokenLife{30};

/// What a one-time code gives access to.
struct StreamGrant {
  std::string run;
  ViewerOwner owner{};
  bool can_command = false;
};

struct StreamTokenLimits {
  std::size_t codes_max = 20'000;          ///< valid codes; guests have at most half of them
  std::size_t codes_per_caller_max = 200;  ///< of one caller
};

/// One-time codes for /ws, so that no address contains a credential. Thread-safe.
class StreamTokens {
 public:
  /// @param issuer  this server's name: it is part of each code, so that every server knows where
  ///    the code is valid
  explicit StreamTokens(const Clock& clock,
                        std::string issuer = "local",
                        StreamTokenLimits limits = {})
      : clock_(clock), issuer_(std::move(issuer)), limits_(limits) {}

  /// A new code of 128 random bits after the issuer's name: "local.abc..". If the caller, the
  /// guests, or all together have their maximum of codes, their oldest becomes invalid.
  std::string Issue(StreamGrant grant);
  /// Returns the grant once, while the code is valid.
  std::optional<StreamGrant> Redeem(std::string_view code);
  /// The issuer's name in a code; empty if it is not a code.
  static std::string_view IssuerOf(std::string_view code);
  /// Makes the codes of these owners invalid.
  void Drop(const std::function<bool(const ViewerOwner&)>& which);
  /// The owners of unused codes, each once.
  std::vector<ViewerOwner> Owners();

 private:
  struct Entry {
    StreamGrant grant;
    MonotonicTime expires;
    std::uint64_t number = 0;  ///< in the order of their issue
  };
  void DropExpired(MonotonicTime now);
  /// When these owners have `max` codes, the oldest of them becomes invalid.
  void KeepBelow(std::size_t max, const std::function<bool(const ViewerOwner&)>& which);

  const Clock& clock_;
  const std::string issuer_;
  const StreamTokenLimits limits_;
  std::mutex mutex_;
  std::uint64_t issued_ = 0;
  std::unordered_map<std::string, Entry> entries_;
};

/// `bytes` random bytes from the kernel as lower-case base32 (RFC 4648 letters, no padding).
std::string RandomCode(int bytes);

}  // namespace faultlab::server
