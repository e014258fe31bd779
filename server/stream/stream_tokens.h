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

/// What a one-time code opens.
struct StreamGrant {
  std::string run;
  ViewerOwner owner{};
  bool can_command = false;
};

struct StreamTokenLimits {
  std::size_t codes_max = 20'000;          ///< that live; guests have at most half of them
  std::size_t codes_per_caller_max = 200;  ///< of one caller
};

/// One-time codes for /ws, so that no credential stands in an address. Thread-safe.
class StreamTokens {
 public:
  /// @param issuer  this server's name: its codes carry it, so that each server knows where they
  /// open
  explicit StreamTokens(const Clock& clock,
                        std::string issuer = "local",
                        StreamTokenLimits limits = {})
      : clock_(clock), issuer_(std::move(issuer)), limits_(limits) {}

  /// A fresh code of 128 random bits behind the issuer's name: "local.abc..". Where the caller, the
  /// guests or everybody have as many as they may, their oldest gives way.
  std::string Issue(StreamGrant grant);
  /// The grant, once, within its life.
  std::optional<StreamGrant> Redeem(std::string_view code);
  /// The name in a code; empty when it is none.
  static std::string_view IssuerOf(std::string_view code);
  /// Codes of such owners open nothing any more.
  void Drop(const std::function<bool(const ViewerOwner&)>& which);
  /// Of the codes that are not used yet, each once.
  std::vector<ViewerOwner> Owners();

 private:
  struct Entry {
    StreamGrant grant;
    MonotonicTime expires;
  };
  void DropExpired(MonotonicTime now);
  /// When such owners have `max` codes, the oldest of these gives way.
  void KeepBelow(std::size_t max, const std::function<bool(const ViewerOwner&)>& which);

  const Clock& clock_;
  const std::string issuer_;
  const StreamTokenLimits limits_;
  std::mutex mutex_;
  std::unordered_map<std::string, Entry> entries_;
};

/// `bytes` random bytes from the kernel as lower-case base32 (RFC 4648 letters, no padding).
std::string RandomCode(int bytes);

}  // namespace faultlab::server
