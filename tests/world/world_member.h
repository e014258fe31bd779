#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/clock.h"
#include "server/experiment/rig_access.h"
#include "server/lab/lab_service.h"
#include "server/run/rig_pool.h"
#include "server/upkeep/asked_checks.h"
#include "server/upkeep/roll_call.h"
#include "tests/world/faulty_store.h"
#include "tests/world/oracle.h"
#include "tests/world/random.h"
#include "tests/world/rehearsal.h"
#include "tests/world/rehearsed_rig.h"

namespace faultlab::server::lab::rehearsal {

/// The start of every world: 2026-01-05T00:00Z, a Monday.
inline constexpr WallTime kWorldStart{Milliseconds{1'767'571'200'000}};

/// A server's clock: the world's time, and what somebody set.
class WorldClock : public Clock {
 public:
  explicit WorldClock(const WorldTime& now) : now_(now) {}
  MonotonicTime Monotonic() const override { return MonotonicTime(now_ + std::chrono::hours(1)); }
  WallTime Wall() const override { return kWorldStart + now_ + off_; }
  void Set(Milliseconds off) { off_ = off; }
  Milliseconds off() const { return off_; }

 private:
  const WorldTime& now_;
  Milliseconds off_{};
};

/// One rig of the world, and who hears it.
struct WorldRig {
  hardware::RigDescription description;
  bool elastic = false;
  std::string member;             ///< beside this server; empty: a far rig
  std::shared_ptr<RigBody> body;  ///< of a bench
  std::shared_ptr<std::deque<InFlight>> line;
  WorldTime cut_until{};  ///< its link is out
};

/// What all members of a world share.
struct Site {
  Site(std::uint64_t seed,
       RehearsalReport& to,
       bool is_shared,
       bool is_calm,
       Milliseconds extended_max)
      : random(seed),
        report(to),
        oracle(is_shared, extended_max),
        shared(is_shared),
        calm(is_calm) {}
  WorldTime now{};
  Random random;
  RehearsalReport& report;
  Oracle oracle;
  const bool shared;           ///< several members on one store
  const bool calm;             ///< nothing fails
  bool clock_checked = false;  ///< members compare their clocks with the store's
  std::vector<WorldRig> rigs;
  Sender sender;
};

/// One server process: what server/app connects and runs on threads, on the world's clock.
class WorldMember : public RigDuties {
 public:
  using OpenStore = std::function<std::unique_ptr<LabStore>()>;
  WorldMember(Site& site, std::string id, OpenStore open);
  ~WorldMember() override { Die(); }
  WorldMember(const WorldMember&) = delete;
  WorldMember& operator=(const WorldMember&) = delete;

  /// Starts the process. False: the store is away, or another process has the place.
  bool Start();
  void Die();
  bool alive() const { return service_ != nullptr; }
  bool awake() const { return alive() && site_.now >= frozen_until_; }
  void Freeze(WorldTime until) { frozen_until_ = until; }
  StoreFaults& faults() { return faults_; }
  WorldClock& clock() { return clock_; }
  const std::string& id() const { return id_; }
  const LabService& service() const { return *service_; }
  std::shared_ptr<const LabState> state() const { return service_->state(); }

  /// An input to the service. nullopt: the process died of it, or the answer was lost.
  template <typename Input>
  auto Do(Input input) -> std::optional<std::invoke_result_t<Input, Scheduler&, WallTime>> {
    using Outcome = std::invoke_result_t<Input, Scheduler&, WallTime>;
    std::optional<Outcome> outcome;
    Guarded([&] { outcome = service_->Do(std::move(input)); });
    const bool heard = outcome && heard_;
    return heard ? std::move(outcome) : std::nullopt;
  }
  /// The turn of every second: time, rigs that come and go, checks, runs.
  void Turn();
  /// A run on the rig of this session, or on any simulator: then `session` is null.
  void BeginRun(UserId user, const Session* session, Milliseconds length);
  /// Somebody commands one of the runs here, some of which should have stopped.
  void CommandRun();
  /// A spectator tries to command.
  void TryToCommand(UserId user, const RigId& rig);
  /// The result of an old check arrives once more.
  void RepeatOldCheck();

  // RigDuties
  void Fence(const RigId& rig, std::uint64_t epoch) override { rig_pool_->Fence(rig, epoch); }
  void StartCleaning(const Lease& lease) override { asked_checks_.Add(lease); }
  bool RunInProgress(const RigId& rig) override { return rig_pool_->Holds(rig); }

 private:
  struct Check {
    Lease lease;
    WorldTime asked{};
    std::optional<WorldTime> done{};
    RigHandle hold{};
    std::optional<RigVerdict> verdict{};  ///< not heard by the lab yet
  };
  struct Run {
    RigHandle hold;
    UserId user{};
    WorldTime until{};
    std::optional<WorldTime> let_go{};  ///< was revoked, and stops then
  };
  struct Late {
    Lease lease;
    UserId user{};
    WorldTime at{};
  };

  void FillBay();
  /// Runs `call`, which may end this process, and shows the oracle what was answered.
  void Guarded(const std::function<void()>& call);
  void Show();
  void GoOnWithChecks();
  bool GoOnWith(Check& check);
  void EndCheck(Check& check);
  void GoOnWithRuns();
  void Hold(core::Result<RigHandle> hold, UserId user, Milliseconds length);
  void AcquireLate();
  bool OlderRunOn(const RigId& rig, std::uint64_t epoch) const;
  WorldRig& RigOf(const RigId& id);

  Site& site_;
  const std::string id_;
  const OpenStore open_;
  WorldClock clock_;
  StoreFaults faults_;
  WorldTime frozen_until_{};
  bool was_frozen_ = false;
  bool heard_ = false;
  std::unique_ptr<RigPool> rig_pool_;
  std::unique_ptr<LabService> service_;
  std::unique_ptr<RigAccess> access_;
  std::optional<RollCall> roll_call_;
  AskedChecks asked_checks_;
  std::list<Check> checks_;
  std::list<Run> runs_;
  std::vector<Late> late_;
  std::vector<std::pair<RigId, std::uint64_t>> old_checks_;
};

}  // namespace faultlab::server::lab::rehearsal
