#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/lab/lab_types.h"
#include "server/storage/database.h"

// How the rigs that need a session were used, as the lab has stored it.
namespace faultlab::server::lab::usage_report {

enum class By : std::uint8_t { kRig, kClass, kCourse, kPerson, kMonth };
/// "rig", "class", "course", "person", "month".
std::string_view Name(By by);

struct Line {
  std::string key;   ///< a rig, a class, the number of a course ("": none) or an account, "2026-11"
  int sessions = 0;  ///< of people, that were taken
  int people = 0;    ///< who had one
  Milliseconds used{};  ///< by them; one that was passed on counts for the last
  Milliseconds jobs{};  ///< by jobs
  int bookings = 0;     ///< that began, or were lost
  int no_shows = 0;     ///< of these: nobody came
  int fell = 0;         ///< of these: the lab had no rig
  int waits = 0;        ///< sessions from the queue
  Milliseconds wait_median{};
  Milliseconds wait_p95{};
  std::optional<Milliseconds> out{};  ///< out of service; not known of courses and people
};

struct Asked {
  By by = By::kMonth;
  Interval during;  ///< in which a session or a booking began
  /// Only what people of these courses did in them; nullopt: all.
  std::optional<Courses> of_courses{};
};

/// In order of the key. Rig use is kept for 400 days.
core::Result<std::vector<Line>> Report(Database& database, const Asked& asked, WallTime now);

}  // namespace faultlab::server::lab::usage_report
