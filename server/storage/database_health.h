#pragma once

#include <mutex>
#include <optional>

#include "server/clock.h"
#include "server/storage/database.h"

namespace faultlab::server {

/// Whether the database accepts a write (a full disk can still be read). Checked at most once a
/// second, however often this is called. Thread-safe.
class DatabaseHealth {
 public:
  DatabaseHealth(Database& database, const Clock& clock) : database_(database), clock_(clock) {}

  core::Status Check();

 private:
  Database& database_;
  const Clock& clock_;
  std::mutex mutex_;
  bool asking_ = false;  ///< the others get the last answer: nobody waits for a silent database
  std::optional<MonotonicTime> asked_;
  core::Status last_ = core::Done{};
};

}  // namespace faultlab::server
