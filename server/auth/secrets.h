#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>

#include "core/types/result.h"

namespace faultlab::server {

/// prefix + 32 random bytes as base64url: session cookies, API keys, links.
std::string NewSecret(std::string_view prefix);
/// Random, below 2^53, so that JSON holds it exactly.
std::uint64_t SecretNumber();
/// BLAKE2b-256 as hex: the form in which the database stores a secret.
std::string HashSecret(std::string_view secret);
/// Compares in constant time.
bool SameSecret(std::string_view a, std::string_view b);

enum class PasswordCost {
  kInteractive,  ///< libsodium's limits for a sign-in: 64 MiB, about 100 ms
  kLeast,        ///< 8 KiB, one pass: what is hashed so can be guessed; for tests
};

/// argon2id (libsodium), at most `parallel_max` at once;
/// a caller that cannot start within `patience` gets kBusy. Blocks its caller: never on a network
/// thread.
class PasswordHasher {
 public:
  explicit PasswordHasher(PasswordCost cost = PasswordCost::kInteractive,
                          int parallel_max = 2,
                          std::chrono::milliseconds patience = std::chrono::seconds(5));

  core::Result<std::string> Hash(std::string_view password);
  /// With an empty hash (no such account) it takes the same time and returns false.
  core::Result<bool> Verify(const std::string& hash, std::string_view password);

 private:
  class Turn;
  const PasswordCost cost_;
  const int parallel_max_;
  const std::chrono::milliseconds patience_;
  std::mutex mutex_;
  std::condition_variable freed_;
  int running_ = 0;
};

}  // namespace faultlab::server
