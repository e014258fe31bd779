#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <type_traits>

#include "server/clock.h"
#include "server/lab/lab_store.h"
#include "server/lab/lease.h"
#include "server/lab/members.h"
#include "server/lab/scheduler.h"
#include "server/storage/database.h"

namespace faultlab::server::lab {

/// What this server does for its own rigs when the lab requires it. Called on the service's thread,
/// without any lock; must not wait for a network and must not call the service from the same stack.
class RigDuties {
 public:
  virtual ~RigDuties() = default;
  /// When this returns, the rig refuses every run and command below `epoch`, and a run with a lower
  /// epoch is stopping. Called after the commit and before any answer is sent.
  virtual void Fence(const RigId& rig, std::uint64_t epoch) = 0;
  /// Begins the check between users; its result comes later by LabService::CleaningDone.
  virtual void StartCleaning(const Lease& lease) = 0;
  /// Whether a run is in progress on this rig, asked at every turn: a run counts as activity.
  virtual bool RunInProgress(const RigId&) { return false; }
};

struct LabServiceOptions {
  Policy policy;  ///< its settings until an admin changes them
  Milliseconds tick{1000};
  /// This server's id among the members of the database. Its rigs are those that it has claimed.
  std::string member = "local";
  std::string address;  ///< "host:port" for the other members
  /// No other server can use this database (its folder is locked): the place of a dead process is
  /// taken at once, not when its lease ends.
  bool alone = true;
  /// If this member's clock differs from the database's by more than this, every input is refused
  /// until the clock is right. 0: not checked.
  Milliseconds clock_error_max{0};
  /// How long the start waits for the place of a dead process. Real time.
  Milliseconds join_patience{0};
  /// Inputs are computed on the caller's thread, one caller at a time, and time passes by TickNow
  /// only: a rehearsal gives the same result each time. Then the store may throw, which leaves this
  /// service as a process that has died.
  bool own_thread = true;
  /// Called after a new state is published, also when another server made it. On the service's
  /// thread: must not block. May be empty.
  std::function<void()> changed{};
};

/// The scheduler with its disk, clock and thread. Inputs that come at the same time share one
/// transaction; each is refused or accepted separately, and the answers are sent after the commit.
/// Two servers on one PostgreSQL take turns by locking the row of the version, and reload when it
/// has changed. Each server is a member with a lease that it renews at each turn. A member that is
/// silent for longer loses its rigs and runs to the others, and joins again when it resumes. After
/// an outage of the database the state is repaired: checks are requested again, practice without a
/// run ends, runs whose end was not stored become interrupted, and deadlines are extended by the
/// time in which no server could answer.
class LabService {
 public:
  static core::Result<std::unique_ptr<LabService>> Open(Database& database,
                                                        const Clock& clock,
                                                        RigDuties& duties,
                                                        LabServiceOptions options);
  static core::Result<std::unique_ptr<LabService>> Open(std::unique_ptr<LabStore> store,
                                                        const Clock& clock,
                                                        RigDuties& duties,
                                                        LabServiceOptions options);
  ~LabService();
  LabService(const LabService&) = delete;
  LabService& operator=(const LabService&) = delete;

  /// Runs `input(scheduler, now)` on the newest state; blocks until it is stored.
  template <typename Input>
  std::invoke_result_t<Input, Scheduler&, WallTime> Do(Input input) {
    using Outcome = std::invoke_result_t<Input, Scheduler&, WallTime>;
    std::optional<Outcome> outcome;
    const core::Status stored =
        Submit([&](Scheduler& scheduler, WallTime now) { outcome.emplace(input(scheduler, now)); });
    if (!stored.ok()) return stored.error();
    return std::move(*outcome);
  }
  /// Applies the passing of time now, without waiting for the next tick.
  core::Status TickNow();
  core::Status CleaningDone(const RigId& rig,
                            std::uint64_t epoch,
                            bool passed,
                            const std::string& detail);

  /// The last stored state. Immutable, shared.
  std::shared_ptr<const LabState> state() const;
  core::Result<std::vector<LabEvent>> EventsSince(UserId user, std::int64_t since, int limit);
  /// The lab's time: the wall clock, but a step of it counts after 5 minutes only, because somebody
  /// may set the clock back.
  WallTime Now() const { return clock_.Wall() - Milliseconds(unbelieved_ms_.load()); }
  /// The member that has this rig; nullopt when no member has it.
  std::optional<Member> MemberOf(const RigId& rig) const;
  /// nullopt when no live member has this id.
  std::optional<Member> MemberWithId(const std::string& id) const;
  /// The live members besides this one.
  std::vector<Member> Others() const;
  const std::string& member() const { return options_.member; }
  /// Member::boot of this process's present membership. A process that has lost its place and joins
  /// again has another one.
  std::string boot() const;
  /// Whether a process was this member before, when this one took its place.
  bool CameBack() const { return came_back_; }
  /// Whether this process is still a member, by its own clock. A process that was frozen, or cut
  /// off from the database, may have lost its rigs before it learns of it. Any thread; cheap.
  bool InForce() const;
  /// With the settings of state().
  Policy policy() const;

 private:
  static constexpr const char* kMemberField = "server_id";

  using Input = std::function<void(Scheduler&, WallTime)>;
  /// The first turn of this process takes its place; later turns keep it.
  enum class Entry : std::uint8_t { kJoins, kStays };
  struct Request {
    Input input;
    std::promise<core::Status> stored;
  };

  LabService(std::unique_ptr<LabStore> store,
             const Clock& clock,
             RigDuties& duties,
             LabServiceOptions options);
  core::Status Submit(Input input);
  void Main();
  void Turn(std::deque<Request> requests);
  core::Status Transact(std::deque<Request>& requests, Entry entry);
  void NoticeClockJump();
  bool BelievesClock() const;
  void NoticeRuns(Scheduler& next, WallTime now);
  core::Status KeepMembership(LabTurn& turn, Scheduler& next, Entry entry, WallTime now);
  Milliseconds ClockOffset() const;
  core::Status CheckClock(LabTurn& turn);
  void InterruptLostRuns(LabTurn& turn, WallTime now);
  bool MayRemove();
  bool IsOwn(const Rig& rig) const { return rig.server == options_.member; }
  void Publish(Scheduler next, std::int64_t version);
  void FenceRigs(const LabState& state);
  void FenceForReplacement(const LabState& state);
  void StartChecks();

  const std::unique_ptr<LabStore> store_;
  const Clock& clock_;
  RigDuties& duties_;
  const LabServiceOptions options_;

  // Used by the service's thread only.
  Scheduler scheduler_;
  std::int64_t version_ = -1;
  std::int64_t published_version_ = -1;
  std::map<RigId, std::uint64_t> fenced_epochs_;
  std::map<RigId, std::uint64_t> checked_epochs_;  ///< epoch of the newest check begun on each rig
  WallTime last_wall_{};
  MonotonicTime last_monotonic_{};
  /// Steps of the wall clock that the lab's time has not followed yet.
  std::atomic<std::int64_t> unbelieved_ms_{0};
  MonotonicTime jumped_at_{};          ///< the newest of these steps
  std::int64_t shifted_version_ = -1;  ///< of the turn that follows them; it may not be stored
  Milliseconds checked_offset_{};      ///< wall minus monotonic time, when last found right
  MonotonicTime last_turn_{};
  std::atomic<MonotonicTime> in_force_until_{};  ///< end of the member's lease, as last stored
  WallTime member_until_{};                      ///< the same in the transaction of this turn
  MonotonicTime remove_from_{};
  bool use_unknown_ = false;   ///< what the rigs are used for, after a time without any server
  MonotonicTime last_look_{};  ///< last search for runs whose end was not stored
  std::map<std::string, MonotonicTime>
      past_runs_;  ///< the time since when their leases are known to have ended

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Request> requests_;
  std::shared_ptr<const LabState> published_;
  std::vector<Member> members_;  ///< as of the last turn
  std::string boot_;
  bool came_back_ = false;  ///< written before the thread starts
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace faultlab::server::lab
