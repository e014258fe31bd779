#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// A secret address per account under which calendar programs, which cannot sign in, fetch its
/// bookings. Only the hash is stored; a new link ends the one before. Thread-safe, stateless.
class CalendarLinks {
 public:
  explicit CalendarLinks(Database& database) : database_(database) {}

  /// The secret, once and never again.
  core::Result<std::string> Create(std::int64_t account_id, WallTime now);
  /// kNotFound when there is none.
  core::Status Remove(std::int64_t account_id);
  /// When the link of this account was made.
  core::Result<std::optional<WallTime>> CreatedAt(std::int64_t account_id);
  /// Whose it is. kNotFound for an unknown secret and for a disabled account.
  core::Result<std::int64_t> AccountOf(const std::string& secret);

 private:
  Database& database_;
};

}  // namespace faultlab::server
