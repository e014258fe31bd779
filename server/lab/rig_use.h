#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/lab/lab_types.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

// What each rig was used for, and for how long: a line whenever that changes, written in the
// transaction of the change.
namespace faultlab::server::lab::rig_use {

/// kOut: offline, in quarantine or in maintenance, or no server was alive.
enum class Use : std::uint8_t { kPeople, kJobs, kChecks, kIdle, kOut };
/// "people", "jobs", "checks", "idle", "out".
std::string_view Name(Use use);
/// Time held for somebody who has not come yet counts as used by people.
Use UseOf(const LabState& state, const Rig& rig);

struct Hours {
  Milliseconds people{};
  Milliseconds jobs{};
  Milliseconds checks{};
  Milliseconds idle{};
  Milliseconds out{};
};
struct Line {
  WallTime at{};
  Use use = Use::kOut;
};

/// Writes a line for each of these rigs whose use is another one than in its newest line.
/// Throws what the database throws, as StoodStill does.
void Note(Transaction& tx, const LabState& state, const std::vector<Rig>& rigs, WallTime now);
/// No server was alive since `from`: the rigs were out since then.
void StoodStill(Transaction& tx, WallTime from);

/// Deletes lines that say nothing about the time since `before`. Throws what the database throws.
void Forget(Transaction& tx, WallTime before);

/// The time that `rig` was used in each of `days` periods of 24 hours, the last of which ends at
/// `until`, oldest first. Time that lies ahead of `now`, or before the first line, is not counted.
core::Result<std::vector<Hours>> HoursOf(
    Database& database, const std::string& rig, WallTime until, int days, WallTime now);
/// The same of lines in order of time. Pure.
std::vector<Hours> SumHours(const std::vector<Line>& lines, WallTime until, int days, WallTime now);

}  // namespace faultlab::server::lab::rig_use
