#pragma once

#include <mutex>
#include <optional>

#include "server/clock.h"
#include "server/storage/database.h"

namespace faultlab::server {

/// Whether the database takes a write: a full disk still reads. Asked at most once a second,
/// however often a stranger asks. Thread-safe.
class DatabaseHealth {
 public:
  DatabaseHealth(Database& database, const Clock& clock) : database_(database), clock_(clock) {}

  core::Status Check();

 private:
  Database& database_;
  const Clock& clock_;
  std::mutex mutex_;
  std::optional<MonotonicTime> asked_;
  core::Status last_ = core::Done{};
};

}  // namespace faultlab::server
