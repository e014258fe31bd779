#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/lti/platform_client.h"
#include "server/lti/platforms.h"
#include "server/storage/database.h"

namespace faultlab::server::lti {

/// Where a platform tells who is in one of its courses (LTI Names and Role Provisioning Services
/// 2.0), and the course here that a link of it leads to.
struct Roster {
  std::int64_t platform = 0;
  std::int64_t course = 0;
  std::string url;
};

/// A student of a platform's course.
struct RosterStudent {
  std::string subject;  ///< as Launch
  std::string login;    ///< that it proposes; empty: none
  std::string name;     ///< for display; may be empty
};

/// The database, the client and the clock must outlive it. Thread-safe.
class Rosters {
 public:
  static constexpr int kStudentsMax = 5000;

  Rosters(Database& database, PlatformClient& client, const Clock& clock)
      : database_(database), client_(client), clock_(clock) {}

  /// Of a launch; known already, it costs a read.
  core::Status Put(const Roster& roster);
  core::Result<std::vector<Roster>> Of(std::int64_t course);
  /// Those who are active. Blocks, for as many pages as the platform gives.
  /// kUnavailable "platform_silent", kNotFound where the platform has no such course any more.
  core::Result<std::vector<RosterStudent>> Read(const Platform& platform,
                                                const Roster& roster,
                                                MonotonicTime until);
  core::Status Forget(const Roster& roster);

 private:
  Database& database_;
  PlatformClient& client_;
  const Clock& clock_;
};

}  // namespace faultlab::server::lti
