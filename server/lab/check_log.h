#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/lab/rig_check.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// One finished check of a rig.
struct CheckRecord {
  std::int64_t id = 0;
  std::string rig{};
  WallTime at{};       ///< when it ended
  std::string kind{};  ///< "between_users", "self_test", "commission", "clear_trip"
  bool passed = false;
  std::string reason{};  ///< why it failed; empty: it passed
  std::vector<CheckStep> steps{};
};

/// The newest checks of each rig, step by step. A check that was put off is none: nothing was
/// looked at. Thread-safe, stateless.
class CheckLog {
 public:
  static constexpr int kKept = 20;  ///< of each rig; older ones are deleted

  explicit CheckLog(Database& database) : database_(database) {}

  /// `check.id` is given by the database.
  core::Status Add(const CheckRecord& check);
  /// Newest first, at most kKept. Empty for a rig that nobody knows.
  core::Result<std::vector<CheckRecord>> List(const std::string& rig);

 private:
  Database& database_;
};

}  // namespace faultlab::server::lab
