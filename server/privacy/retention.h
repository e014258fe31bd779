#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// How long things are kept, in days; 0 = for ever.
struct RetentionRules {
  int guest_days = 30;     ///< recordings of guests, after they were made
  int student_days = 365;  ///< recordings of students, after the last of their courses has ended
  int job_days = 90;       ///< jobs and the recordings of their runs, after they ended
  int news_days = 365;     ///< messages to users; used links and sign-ins that have ended
};

/// One thing that has been kept long enough.
struct Expired {
  std::string kind;  ///< "recording", "job"
  std::string id;
  std::string owner;
  std::string rule;  ///< the member of RetentionRules that applies
  WallTime created_at{};
};

struct RetentionReport {
  std::vector<Expired> items;
  std::int64_t news = 0;     ///< lines told
  std::int64_t stale = 0;    ///< links, sign-ins
  std::int64_t benches = 0;  ///< descriptions that no rig, recording or calibration names
};

/// Finds what has been kept long enough, oldest first, at most 10 000 things at a time. With
/// `remove` it deletes them and writes one audit line, all in one transaction. It never touches
/// running runs, what a waiting or running job needs, and the source of a running replay.
core::Result<RetentionReport> Retain(Database& database,
                                     const RetentionRules& rules,
                                     WallTime now,
                                     bool remove);

}  // namespace faultlab::server
