#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

enum class AlarmKind : std::uint8_t {
  kQuarantined,   ///< somebody took the rig out, or its check did not end
  kCheckFailed,   ///< a check between users failed
  kInterlock,     ///< an interlock tripped
  kDeltaStrays,   ///< the delay between output and reading is not the described one
  kSilent,        ///< the rig is offline
  kRelayWorn,     ///< a relay is near its rated life
  kStorageSmall,  ///< a server's disk is nearly full
  kRestarted,     ///< a server has started again
  kJobFailed,     ///< a job could not be done
  kHoursEnd,      ///< the opening hours of a class end soon, or have ended
};
/// "quarantined", "check_failed", "interlock", "delta_strays", "silent", "relay_worn",
/// "storage_small", "restarted", "job_failed", "hours_end".
std::string_view Name(AlarmKind kind);
/// Of a kind that lasts as long as its cause. The others happen once, and are over when somebody
/// has acknowledged them.
bool Lasts(AlarmKind kind);

struct Alarm {
  std::int64_t id = 0;
  AlarmKind kind = AlarmKind::kQuarantined;
  std::string subject;  ///< a rig; of the last kinds a server, a job's rig, a class
  std::string text;     ///< what the rig or the server said, as last told
  WallTime at{};
  WallTime last{};         ///< when it was told last
  std::int64_t times = 1;  ///< how often it was told
  std::optional<WallTime> ended{};
  std::optional<WallTime> acked{};
  std::int64_t acked_by = 0;  ///< account
};

/// What an operator should look at. One open alarm of a kind and subject at most: telling it again
/// counts. Thread-safe, stateless; servers of one database may tell the same.
class Alarms {
 public:
  static constexpr int kKept = 500;  ///< that have ended; older ones are deleted

  explicit Alarms(Database& database) : database_(database) {}

  core::Status Raise(AlarmKind kind,
                     const std::string& subject,
                     const std::string& text,
                     WallTime now);
  /// The cause is gone. No effect on an alarm that is not open.
  core::Status End(AlarmKind kind, const std::string& subject, WallTime now);
  struct Acknowledged {
    Alarm alarm;
    bool first = false;  ///< nobody had acknowledged it before
  };
  /// kNotFound when there is no such alarm. Who acknowledged first stays.
  core::Result<Acknowledged> Acknowledge(std::int64_t id, std::int64_t account, WallTime now);
  /// Newest first, below `before` (0 = from the newest). With `all` false only those that are open
  /// or not acknowledged.
  core::Result<std::vector<Alarm>> List(bool all, std::int64_t before, int limit);
  core::Result<std::vector<Alarm>> Open();

 private:
  Database& database_;
};

}  // namespace faultlab::server::lab
