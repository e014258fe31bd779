#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::course {

/// Member of Assignment::plan_json: true where each student chooses the excitation; the plan's own
/// is that of whoever chooses none.
inline constexpr const char* kFreeExcitation = "free_excitation";

/// A task of a course: blind trials with faults drawn from a pool. It keeps its own copy of the
/// pool, so that whatever becomes of the fault set, all its trials are drawn alike. Name, times,
/// attempts, release and rubric may change, what is drawn and played may not.
struct Assignment {
  std::int64_t id = 0;
  std::int64_t course = 0;
  std::int64_t author = 0;
  std::int64_t fault_set = 0;
  std::string name;
  std::string bench;                ///< core::Bench::name
  std::string pool_json;            ///< FaultPool
  std::string plan_json;            ///< of POST runs, without faults: what every trial plays
  std::string rubric_json;          ///< Rubric
  std::int64_t rubric_version = 1;  ///< rises when it changes: what it graded is graded again
  WallTime opens{};
  WallTime due{};
  int attempts = 1;             ///< of a student, or of a group
  int group_max = 1;            ///< members of a group, up to kGroupMax; 1: there are none
  bool on_bench = false;        ///< on a rig of its class, in a session; otherwise on a simulator
  bool reveal_at_once = false;  ///< the truth with the grade; otherwise when it is due
  std::string secret;           ///< of its draws; leaves the server by no way
  WallTime created_at{};
  std::int64_t version = 1;
  bool deleted = false;                         ///< no longer listed; its trials stay
  std::map<std::int64_t, WallTime> extensions;  ///< by account: due for them, later than for others

  /// When it is due for this person.
  WallTime DueFor(std::int64_t account) const;
};

/// Thread-safe, stateless.
class Assignments {
 public:
  explicit Assignments(Database& database) : database_(database) {}

  static constexpr int kOfCourseMax = 200;

  /// kConflict "assignments_full" when the course has kOfCourseMax.
  core::Result<Assignment> Create(Assignment assignment);
  core::Result<Assignment> Get(std::int64_t id);
  /// Of the courses that this account attends or teaches; nullopt: all. In order of id.
  core::Result<std::vector<Assignment>> List(std::optional<std::int64_t> account,
                                             std::int64_t after,
                                             int limit);
  /// Name, times, attempts, release and rubric. kStale when `version` is not the stored one.
  core::Result<Assignment> Change(const Assignment& assignment, std::int64_t version);
  /// nullopt: as for the others.
  core::Status Extend(std::int64_t id, std::int64_t account, std::optional<WallTime> due);
  /// It is no longer listed; its trials stay.
  core::Status Delete(std::int64_t id);

 private:
  Database& database_;
};

}  // namespace faultlab::server::course
