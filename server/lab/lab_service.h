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
#include <set>
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

/// What this server does for its own rigs when the lab says so. Called on the service's thread,
/// never with a lock held; must not wait for a network and must not call back into the service from
/// the same stack.
class RigDuties {
 public:
  virtual ~RigDuties() = default;
  /// When this returns, the rig refuses every run and command below `epoch`, and what ran under one
  /// is stopping. Called after the commit and before anybody is told of it.
  virtual void Fence(const RigId& rig, std::uint64_t epoch) = 0;
  /// Begin the check between users; answer later by LabService::CleaningDone.
  virtual void StartCleaning(const Lease& lease) = 0;
  /// Is a run in progress on this rig? Asked at every turn: a run is work, not idleness.
  virtual bool RunInProgress(const RigId&) { return false; }
};

struct LabServiceOptions {
  Policy policy;
  Milliseconds tick{1000};
  /// This server among those of the database. Its rigs are those that it has claimed.
  std::string member = "local";
  std::string address;  ///< "host:port", for the others
  /// No other server can have this database (its folder is locked): a place that a dead process
  /// left is taken at once, not when its lease ends.
  bool alone = true;
  /// Members whose clocks are further off the database's than this take no part: every input is
  /// refused until the clock is right. 0: not looked at.
  Milliseconds clock_error_max{0};
  /// How long the start waits for a place that a dead process left. Real time.
  Milliseconds join_patience{0};
  /// Told after a new state is published, also when another server made it. On the service's
  /// thread: must not block. May be empty.
  std::function<void()> changed{};
};

/// The scheduler with its disk, clock and thread. Inputs that come at the same time share one
/// transaction, each is refused or accepted by itself, and everybody is answered after the commit.
/// Two servers on one PostgreSQL take turns on the row of the version and reload when it moved.
/// Each is a member with a lease that it renews with its turns: one that is silent for longer has
/// lost its rigs and runs to the others, and joins anew when it wakes up. What an outage of the
/// database swallowed is made up for from the state: checks are asked for again, practice that
/// nobody runs ends, runs whose end was lost are interrupted, and nobody is late for the time in
/// which no server could answer.
class LabService {
 public:
  static core::Result<std::unique_ptr<LabService>> Open(Database& database,
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
  /// Time passes now, without waiting for the next tick.
  core::Status TickNow();
  core::Status CleaningDone(const RigId& rig,
                            std::uint64_t epoch,
                            bool passed,
                            const std::string& detail);

  /// The last stored state. Immutable, shared.
  std::shared_ptr<const LabState> state() const;
  core::Result<std::vector<LabEvent>> EventsSince(UserId user, std::int64_t since, int limit);
  WallTime Now() const { return clock_.Wall(); }
  /// The member that has this rig, nullopt when nobody has.
  std::optional<Member> MemberOf(const RigId& rig) const;
  /// nullopt when no such server is alive.
  std::optional<Member> MemberWithId(const std::string& id) const;
  /// The live members besides this one.
  std::vector<Member> Others() const;
  const std::string& member() const { return options_.member; }
  /// Is this process a member still, by its own clock? One that was frozen, or cut off from the
  /// database, may have lost its rigs to others before it hears of it. Any thread; cheap.
  bool InForce() const;
  const Policy& policy() const { return options_.policy; }

 private:
  using Input = std::function<void(Scheduler&, WallTime)>;
  /// Of a turn: the first one of this process takes the place, the others keep it.
  enum class Entry : std::uint8_t { kJoins, kStays };
  struct Request {
    Input input;
    std::promise<core::Status> stored;
  };

  LabService(Database& database, const Clock& clock, RigDuties& duties, LabServiceOptions options);
  core::Status Submit(Input input);
  void Main();
  void Turn(std::deque<Request> requests);
  core::Status Transact(std::deque<Request>& requests, Entry entry);
  void NoticeClockJump(Scheduler& next);
  void NoticeRuns(Scheduler& next, WallTime now);
  core::Status KeepMembership(Transaction& tx, Scheduler& next, Entry entry, WallTime now);
  Milliseconds ClockOffset() const;
  core::Status CheckClock(Transaction& tx);
  void InterruptLostRuns(Transaction& tx, WallTime now);
  bool MayRemove();
  bool IsOwn(const Rig& rig) const { return rig.server == options_.member; }
  void Publish(Scheduler next, std::int64_t version);
  void FenceRigs(const LabState& state);
  void FenceForReplacement(const LabState& state);
  void StartChecks();

  Database& database_;
  const Clock& clock_;
  RigDuties& duties_;
  const LabServiceOptions options_;
  const std::string boot_;

  // Of the thread.
  Scheduler scheduler_;
  std::int64_t version_ = -1;
  std::int64_t published_version_ = -1;
  std::map<RigId, std::uint64_t> fenced_epochs_;
  std::map<RigId, std::uint64_t> checked_epochs_;  ///< of the newest check that was begun
  WallTime last_wall_{};
  MonotonicTime last_monotonic_{};
  Milliseconds checked_offset_{};  ///< wall less monotonic time when the clock was last found right
  MonotonicTime last_turn_{};
  std::atomic<MonotonicTime> in_force_until_{};  ///< of the member's lease, when it was last stored
  WallTime member_until_{};                      ///< as the transaction of the turn has it
  MonotonicTime remove_from_{};
  MonotonicTime last_look_{};  ///< at runs whose end may be lost
  std::map<std::string, MonotonicTime>
      past_runs_;  ///< since when their leases are known to be over

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Request> requests_;
  std::shared_ptr<const LabState> published_;
  std::vector<Member> members_;  ///< as of the last turn
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace faultlab::server::lab
