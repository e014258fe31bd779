#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lti {

/// The place of a student's grade of an exercise in a platform's gradebook.
struct Seat {
  std::int64_t platform = 0;
  std::int64_t assignment = 0;
  std::int64_t account = 0;
  std::string subject;   ///< the student, as the platform names them
  std::string lineitem;  ///< address of the column
};

/// Thread-safe, stateless.
class Seats {
 public:
  explicit Seats(Database& database) : database_(database) {}

  /// Of a launch, in place of an earlier one. What the student has already is sent.
  core::Status Put(const Seat& seat);
  core::Result<std::optional<Seat>> Find(std::int64_t platform,
                                         std::int64_t assignment,
                                         std::int64_t account);
  /// Puts a message into the outbox for each seat whose grade may have changed (MarkDue). One
  /// waits for each seat at most: it is the grade of the time of its sending that is sent.
  /// @returns whether there was one
  core::Result<bool> Gather(WallTime now);

 private:
  Database& database_;
};

}  // namespace faultlab::server::lti
