#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// A secret address per account, at which calendar programs, which cannot sign in, fetch its
/// bookings. Only the hash is stored; a new link replaces the old one. Thread-safe, stateless.
class CalendarLinks {
 public:
  explicit CalendarLinks(Database& database) : database_(database) {}

  /// Returns the secret, which cannot be read again.
  core::Result<std::string> Create(std::int64_t account_id, WallTime now);
  /// kNotFound when the account has no link.
  core::Status Remove(std::int64_t account_id);
  /// When the link of this account was made.
  core::Result<std::optional<WallTime>> CreatedAt(std::int64_t account_id);
  /// The account of a link. kNotFound for an unknown secret and for a disabled account.
  core::Result<std::int64_t> AccountOf(const std::string& secret);

 private:
  Database& database_;
};

}  // namespace faultlab::server
