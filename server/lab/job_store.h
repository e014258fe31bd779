#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// A run that a machine asked for. States: waiting, running, finished, failed, cancelled.
struct Job {
  std::string id;
  std::string owner;  ///< Principal::owner_key()
  std::int64_t account_id = 0;
  std::string batch;  ///< jobs of one request share it
  std::string name;
  std::string body;  ///< a POST runs body; of Claim alone, and gone when the job has ended
  // Of the body, for lists; empty when it does not say.
  std::string run_name;
  std::string rig;
  std::string recording;  ///< to be diagnosed
  std::string state = "waiting";
  std::string run_id;
  std::string error;
  std::string result;     ///< JSON of a job that makes no run
  std::string server_id;  ///< with `attempts` the newest claim; empty before the first
  WallTime created_at{};
  std::optional<WallTime> started_at;
  std::optional<WallTime> ended_at;
  int attempts = 0;
};

/// The queue of jobs, shared by all servers of a database. A claim is a lease that its server keeps
/// alive; when the server dies the lease runs out and the job waits again, three times at most. A
/// server that was frozen meanwhile changes nothing of a claim that is another one's now.
/// Thread-safe, stateless.
class JobStore {
 public:
  explicit JobStore(Database& database) : database_(database) {}

  static constexpr int kAttemptsMax = 3;
  static constexpr int kWaitingMax = 1000;  ///< of an owner
  /// Of the bodies of an owner's jobs that wait or run.
  static constexpr std::int64_t kBodyBytesMax = 16 << 20;
  /// Of an owner's jobs that ended without a run, the newest are kept.
  static constexpr int kIdleKept = 1000;

  /// All or none. kTooMany, or kConflict "jobs_full" for their bytes, when the owner would have too
  /// many.
  core::Status Add(const std::vector<Job>& jobs);
  core::Result<Job> Get(const std::string& id);
  /// Bytes of the bodies of an owner's jobs that wait or run.
  core::Result<std::int64_t> BodyBytesOf(const std::string& owner);
  /// Newest first; cursor as in RecordingStore::List. Empty batch: all of the owner.
  core::Result<std::vector<Job>> List(const std::string& owner,
                                      const std::string& batch,
                                      std::int64_t before_ms,
                                      const std::string& before_id,
                                      int limit);
  /// The next waiting job, now leased to this server; the owner with the fewest running goes first.
  /// SKIP LOCKED on PostgreSQL: no two servers get the same. nullopt: nothing waits.
  core::Result<std::optional<Job>> Claim(const std::string& server_id,
                                         WallTime now,
                                         WallTime lease_until);
  // What follows is for the holder of the claim, with the job as Claim gave it: kStale, and nothing
  // is changed, when the job was taken from it meanwhile (its lease ran out). Stop its run then.
  core::Status Renew(const Job& claimed, WallTime lease_until);
  core::Status SetRun(const Job& claimed, const std::string& run_id);
  core::Status SetResult(const Job& claimed, const std::string& result);
  core::Status Finish(const Job& claimed,
                      const std::string& state,
                      const std::string& error,
                      WallTime now);
  /// Back to waiting, for a rig was not free; not claimed again before `not_before`. Does not count
  /// as an attempt.
  core::Status GiveBack(const Job& claimed, WallTime not_before);
  /// Back to waiting for the server that has its rig; nobody else claims it before `until`.
  core::Status HandTo(const Job& claimed, const std::string& server_id, WallTime until);

  /// Only a waiting job (kConflict).
  core::Status Cancel(const std::string& id, WallTime now);
  /// Leases that ran out, and at start those of this very server.
  core::Result<int> Reap(WallTime now, const std::string& own_server_id);

 private:
  /// Sets `columns` of a job whose claim still holds.
  template <typename Bind>
  core::Status Change(const Job& claimed,
                      Durability durability,
                      const char* columns,
                      const Bind& bind);

  Database& database_;
};

}  // namespace faultlab::server::lab
