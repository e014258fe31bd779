#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// A named fault schedule of an instructor. Immutable once a run has used it: a change then makes a
/// new fault set with the next version number, which `replaces` the old one.
struct FaultSet {
  std::int64_t id = 0;
  std::int64_t course_id = 0;  ///< 0: in no course, visible to its author only
  std::int64_t author = 0;
  std::string name;
  std::string bench;  ///< core::Bench::name: its components have the faults
  std::int64_t version = 1;
  bool visible = true;      ///< to the students of the course
  std::string faults_json;  ///< array as in POST runs, validated by the caller
  /// What blind trials are drawn from (course::FaultPool); then `faults_json` stands for it, and no
  /// run plays the set. Empty: a schedule.
  std::string pool_json;
  bool used = false;
  bool deleted = false;
  std::int64_t replaces = 0;
  WallTime created_at{};
};

/// Thread-safe, stateless.
class FaultSets {
 public:
  explicit FaultSets(Database& database) : database_(database) {}

  static constexpr int kOfAuthorMax = 500;

  /// kConflict "fault_sets_full" when the author has kOfAuthorMax.
  core::Result<FaultSet> Create(FaultSet set);
  /// kStale when `version` is not the stored one. A used set stays unchanged; a new set with a new
  /// id is returned.
  core::Result<FaultSet> Change(const FaultSet& set, std::int64_t version);
  core::Status Delete(std::int64_t id, std::int64_t version);
  core::Result<FaultSet> Get(std::int64_t id);
  struct Reader {
    std::int64_t account = 0;
    bool makes_sets = false;  ///< by the role of today
  };
  /// The visible sets of the courses that `reader` attends; of who makes sets, also their own and
  /// those of the courses that they teach; nullopt: all. Without deleted and replaced sets, in
  /// order of id, after `after`.
  core::Result<std::vector<FaultSet>> List(std::optional<Reader> reader,
                                           std::int64_t after,
                                           int limit);
  core::Status MarkUsed(std::int64_t id);

 private:
  Database& database_;
};

}  // namespace faultlab::server
