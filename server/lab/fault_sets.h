#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// A named fault schedule of an instructor. Immutable once a run has used it: a change then makes a
/// new one with the next version number, which `replaces` the old.
struct FaultSet {
  std::int64_t id = 0;
  std::int64_t course_id = 0;  ///< 0: of no course, only its author's
  std::int64_t author = 0;
  std::string name;
  std::int64_t version = 1;
  bool visible = true;      ///< to the students of the course
  std::string faults_json;  ///< array as in POST runs, validated by the caller
  bool used = false;
  std::int64_t replaces = 0;
  WallTime created_at{};
};

/// Thread-safe, stateless.
class FaultSets {
 public:
  explicit FaultSets(Database& database) : database_(database) {}

  core::Result<FaultSet> Create(FaultSet set);
  /// kStale when `version` is not the stored one. A used set stays as it is and a new one, with a
  /// new id, is returned.
  core::Result<FaultSet> Change(const FaultSet& set, std::int64_t version);
  core::Status Delete(std::int64_t id, std::int64_t version);
  core::Result<FaultSet> Get(std::int64_t id);
  /// All that are not deleted nor replaced, by id.
  core::Result<std::vector<FaultSet>> List();
  core::Status MarkUsed(std::int64_t id);

 private:
  Database& database_;
};

}  // namespace faultlab::server::lab
