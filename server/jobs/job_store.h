#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/types/result.h"
#include "server/storage/claimant.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// A run that a program requested. States: waiting, running, finished, failed, cancelled.
struct Job {
  std::string id;
  std::string owner;  ///< Principal::owner_key()
  std::int64_t account_id = 0;
  std::string batch;  ///< jobs of one request share it
  std::string name;
  std::string body;  ///< a POST runs body; loaded for who does the job, deleted at the end
  // Taken from the body, for lists; empty when the body does not contain it.
  std::string run_name;
  std::string rig;
  std::string recording;  ///< to be diagnosed; such a job computes, and needs no rig
  std::string state = "waiting";
  std::string run_id;
  std::string error;
  std::string result;  ///< JSON result of a job that makes no run
  // Of the newest claim, together with `attempts`; empty before the first.
  std::string server_id;
  std::string boot;
  WallTime created_at{};
  std::optional<WallTime> started_at;
  std::optional<WallTime> ended_at;
  int attempts = 0;
};

/// Which waiting jobs a server may not begin now.
struct JobsLeftOut {
  struct Kinds {
    bool runs = false;
    bool computing = false;  ///< those of a recording, which need no rig
  };
  struct OfOwner {
    Kinds kinds;
    std::vector<std::string> ids;
  };
  std::vector<std::string> on_rigs;  ///< those that name one of these
  Kinds kinds;                       ///< of everybody
  std::map<std::string, OfOwner> of;
};

/// The queue of jobs, shared by all servers of a database. A claim lasts as long as its server's
/// membership; if that ends, the job waits again, three times at most. Every write of a claim is
/// fenced by member, boot and attempt: a server that was frozen in the meantime cannot change a job
/// that another one may have claimed. Thread-safe.
class JobStore {
 public:
  explicit JobStore(Database& database) : database_(database) {}

  static constexpr int kAttemptsMax = 3;
  static constexpr int kWaitingMax = 20'000;  ///< per owner
  /// Largest total size of the bodies of an owner's waiting and running jobs.
  static constexpr std::int64_t kBodyBytesMax = 16 << 20;
  /// Most samples of the recordings of an owner's waiting and running jobs: hours of work.
  static constexpr std::int64_t kSamplesMax = 100'000'000;
  /// Of an owner's jobs that ended without a run, this many of the newest are kept.
  static constexpr int kIdleKept = 1000;

  /// `added` is called after jobs were added here. To be called before the first Add.
  void OnAdded(std::function<void()> added) { added_ = std::move(added); }

  /// Adds all jobs or none. kTooMany when the owner would have too many jobs; kConflict "jobs_full"
  /// when their bodies would be too large, "jobs_work_full" when their recordings would be too
  /// long.
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
  /// The oldest waiting jobs that name one of `rigs`: `limit` of each owner and rig, with their
  /// bodies.
  core::Result<std::vector<Job>> WaitingOn(const std::vector<std::string>& rigs, int limit);

  /// The next waiting job, now of this claimant; the owner with the fewest running jobs goes first,
  /// then who has waited longest since the last of them ended.
  /// SKIP LOCKED on PostgreSQL: no two servers get the same job. nullopt: no such job waits, or the
  /// membership has ended.
  core::Result<std::optional<Job>> Claim(const Claimant& who,
                                         const JobsLeftOut& left_out,
                                         WallTime now);
  /// The same for this job. nullopt: it does not wait.
  core::Result<std::optional<Job>> ClaimThis(const Claimant& who,
                                             const std::string& id,
                                             WallTime now);
  // The following functions are for the holder of the claim, with the job as Claim returned it.
  // kStale, without any change, when the claim is over (the membership has ended, the job was
  // cancelled): then stop the job's run.
  core::Status SetRun(const Job& claimed, const std::string& run_id);
  core::Status SetResult(const Job& claimed, const std::string& result);
  core::Status Finish(const Job& claimed,
                      const std::string& state,
                      const std::string& error,
                      WallTime now);
  /// Back to waiting, because no rig was free. Does not count as an attempt.
  core::Status GiveBack(const Job& claimed);
  /// The jobs whose claims by this membership are valid.
  core::Result<std::vector<std::string>> HeldBy(const Claimant& who);

  /// The jobs of one request. kNotFound: there is none.
  struct Batch {
    std::string owner;
    std::string name;
    WallTime created_at{};
    std::map<std::string, std::int64_t> count;  ///< of each state that one of them has
    std::optional<WallTime> ended_at;           ///< when the last one ended; none: one lives
  };
  core::Result<Batch> BatchOf(const std::string& batch);
  /// Ends those that wait or run. @returns these; as Cancel.
  core::Result<std::vector<Job>> CancelBatch(const std::string& batch, WallTime now);

  /// Ends a waiting or running job; any other gives kConflict. Its claim is over: whoever has its
  /// run stops it.
  core::Result<Job> Cancel(const std::string& id, WallTime now);
  /// Returns jobs whose memberships have ended to the queue.
  core::Result<int> Reap(WallTime now);

 private:
  /// Sets `columns` of a job if its claim is still valid.
  core::Status Change(const Job& claimed, const Parameters& columns);

  Database& database_;
  std::function<void()> added_;
};

}  // namespace faultlab::server
