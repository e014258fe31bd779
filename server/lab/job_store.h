#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// A run that a program requested. States: waiting, running, finished, failed, cancelled.
struct Job {
  std::string id;
  std::string owner;  ///< Principal::owner_key()
  std::int64_t account_id = 0;
  std::string batch;  ///< jobs of one request share it
  std::string name;
  std::string body;  ///< a POST runs body; loaded by Claim alone, deleted at the end
  // Taken from the body, for lists; empty when the body does not contain it.
  std::string run_name;
  std::string rig;
  std::string recording;  ///< to be diagnosed
  std::string state = "waiting";
  std::string run_id;
  std::string error;
  std::string result;     ///< JSON result of a job that makes no run
  std::string server_id;  ///< of the newest claim, with `attempts`; empty before the first
  WallTime created_at{};
  std::optional<WallTime> started_at;
  std::optional<WallTime> ended_at;
  int attempts = 0;
};

/// The queue of jobs, shared by all servers of a database. A claim is a lease that its server
/// renews; if the server dies, the lease ends and the job waits again, three times at most. A
/// server that was frozen in the meantime cannot change a job that another server has claimed.
/// Thread-safe, stateless.
class JobStore {
 public:
  explicit JobStore(Database& database) : database_(database) {}

  static constexpr int kAttemptsMax = 3;
  static constexpr int kWaitingMax = 1000;  ///< per owner
  /// Largest total size of the bodies of an owner's waiting and running jobs.
  static constexpr std::int64_t kBodyBytesMax = 16 << 20;
  /// Of an owner's jobs that ended without a run, this many of the newest are kept.
  static constexpr int kIdleKept = 1000;

  /// Adds all jobs or none. kTooMany when the owner would have too many jobs; kConflict "jobs_full"
  /// when their bodies would be too large.
  core::Status Add(const std::vector<Job>& jobs);
  core::Result<Job> Get(const std::string& id);
  /// Total size of the bodies of an owner's waiting and running jobs.
  core::Result<std::int64_t> BodyBytesOf(const std::string& owner);
  /// Newest first; cursor as in RecordingStore::List. Empty batch: all jobs of the owner.
  core::Result<std::vector<Job>> List(const std::string& owner,
                                      const std::string& batch,
                                      std::int64_t before_ms,
                                      const std::string& before_id,
                                      int limit);
  /// The next waiting job, now leased to this server; the owner with the fewest running jobs goes
  /// first. SKIP LOCKED on PostgreSQL: no two servers get the same job. nullopt: no job waits.
  core::Result<std::optional<Job>> Claim(const std::string& server_id,
                                         WallTime now,
                                         WallTime lease_until);
  // The following functions are for the holder of the claim, with the job as Claim returned it.
  // kStale, without any change, when another server has the job in the meantime (the lease ended):
  // then stop the job's run.
  core::Status Renew(const Job& claimed, WallTime lease_until);
  core::Status SetRun(const Job& claimed, const std::string& run_id);
  core::Status SetResult(const Job& claimed, const std::string& result);
  core::Status Finish(const Job& claimed,
                      const std::string& state,
                      const std::string& error,
                      WallTime now);
  /// Back to waiting, because no rig was free; not claimed again before `not_before`. Does not
  /// count as an attempt.
  core::Status GiveBack(const Job& claimed, WallTime not_before);
  /// Back to waiting for the server that has the rig; no other server claims the job before
  /// `until`.
  core::Status HandTo(const Job& claimed, const std::string& server_id, WallTime until);

  /// Cancels a waiting job; any other gives kConflict.
  core::Status Cancel(const std::string& id, WallTime now);
  /// Returns jobs whose leases have ended to the queue, and at the start also those of this server.
  core::Result<int> Reap(WallTime now, const std::string& own_server_id);

 private:
  /// Sets `columns` of a job if its claim is still valid.
  template <typename Bind>
  core::Status Change(const Job& claimed,
                      Durability durability,
                      const char* columns,
                      const Bind& bind);

  Database& database_;
};

}  // namespace faultlab::server::lab
