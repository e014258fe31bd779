#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/auth/throttle.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::course {

inline constexpr int kGroupMax = 3;

/// Students who share the trials of one assignment: attempts, answers and points.
struct Group {
  std::int64_t id = 0;
  std::string code;                   ///< by which others join
  std::vector<std::int64_t> members;  ///< accounts, in order
};

/// A group is formed by one student and joined by others with its code, before any of them begins a
/// trial. Thread-safe; it remembers guesses of codes, nothing else.
class Groups {
 public:
  explicit Groups(Database& database) : database_(database) {}

  core::Result<std::optional<Group>> Of(std::int64_t assignment, std::int64_t account);
  /// All of an assignment, by member.
  core::Result<std::map<std::int64_t, Group>> All(std::int64_t assignment);
  /// kConflict "in_group", "group_begun": somebody of it has begun a trial.
  core::Result<Group> Form(std::int64_t assignment, std::int64_t account);
  /// These, kInvalid "group_unknown", and kConflict "group_full" where it has `most` members.
  /// kTooMany for who goes on guessing.
  /// @param code  as people write it: spaces and small letters do not matter
  core::Result<Group> Join(std::int64_t assignment,
                           std::int64_t account,
                           const std::string& code,
                           int most,
                           WallTime now);
  /// Nothing happens to whoever is in none. kConflict "group_begun".
  core::Status Leave(std::int64_t assignment, std::int64_t account);

 private:
  Database& database_;
  Throttle guesses_{10};  ///< by account
};

/// In SQL: the account_id of a row is this person's, or that of somebody in the same group.
std::string WithMates(std::int64_t assignment, std::int64_t account);

}  // namespace faultlab::server::course
