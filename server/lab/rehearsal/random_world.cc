#include "server/lab/rehearsal/random_world.h"

#include <algorithm>
#include <array>
#include <functional>
#include <vector>

#include "server/lab/lease.h"
#include "server/lab/rehearsal/random.h"
#include "server/lab/scheduler.h"

namespace faultlab::server::lab {
namespace {

constexpr std::int64_t kStepsPerWorld = 20'000;
constexpr WallTime kStart{Milliseconds{1'767'225'600'000}};
constexpr Milliseconds kHour{3'600'000};
constexpr std::size_t kCredentialsKept = 64;
constexpr const char* kServer = "server";

/// The state of one rig outside the scheduler: its fence, and the session that it last served.
struct RigSide {
  Fence fence;
  SessionId last_session{};
  std::uint64_t last_check = 0;  ///< epoch of the newest check that has begun
  bool checked = false;          ///< a check between users has passed since the last session
};

struct Credential {
  RigId rig;
  std::uint64_t epoch = 0;
  UserId user{};
  SessionId session{};
};

struct PendingCheck {
  RigId rig;
  std::uint64_t epoch = 0;
  WallTime done{};
  bool passes = true;
};

/// Inputs are random, so most refusals are correct and are ignored; only the invariants are
/// checked.
class World {
 public:
  World(std::uint64_t seed, RehearsalReport& report) : random_(seed), report_(report) {
    const auto rigs = 1 + random_.Below(8);
    for (std::int64_t i = 0; i < rigs; ++i) {
      const RigId id = "rig-" + std::to_string(i);
      const bool elastic = random_.Chance(0.2);
      const std::string rig_class = elastic ? "sim" : (random_.Chance(0.3) ? "b" : "a");
      (void)scheduler_.AddRig(id, rig_class, elastic);
      (void)scheduler_.Claim(id, kServer, now_);
      rigs_.push_back(id);
    }
    Deliver();
  }

  void Step() {
    const bool crash = random_.Chance(0.0005);
    const bool before_commit = crash && random_.Chance(0.5);
    std::optional<Scheduler> committed;
    if (before_commit) committed = scheduler_;
    Act();
    if (before_commit) {
      scheduler_ = *committed;  // the transaction was not stored
    } else {
      Observe();
    }
    if (crash) {
      ++report_.crashes;
      checks_.clear();  // lost with the process
      for (auto& [id, side] : sides_) side.last_check = 0;
      const LabState stored = scheduler_.state();
      scheduler_ = Scheduler(scheduler_.policy(), stored);
      scheduler_.Recover(now_);
    }
    Deliver();
    (void)scheduler_.TakeNotices();
    (void)scheduler_.TakeChanges();
    Judge();
    ++report_.steps;
  }

 private:
  UserId AnyUser() { return UserId{1 + random_.Below(12)}; }
  const RigId& AnyRig() { return rigs_[static_cast<std::size_t>(random_.Below(Size(rigs_)))]; }
  std::string AnyClass() {
    static constexpr std::array<const char*, 4> kClasses = {"a", "a", "b", "sim"};
    return kClasses[static_cast<std::size_t>(random_.Below(4))];
  }
  template <typename Container>
  static std::int64_t Size(const Container& container) {
    return static_cast<std::int64_t>(container.size());
  }
  template <typename Map>
  auto AnyId(const Map& map) {
    using Id = typename Map::key_type;
    if (map.empty()) return Id{};
    auto entry = map.begin();
    std::advance(entry, random_.Below(Size(map)));
    return entry->first;
  }

  void Act() {
    const LabState& state = scheduler_.state();
    const double dice = random_.Uniform();
    if (dice < 0.30) {
      now_ += random_.Exponential(Milliseconds{random_.Chance(0.05) ? 300'000 : 8'000});
      FinishChecks();
      scheduler_.Tick(now_);
    } else if (dice < 0.42) {
      TicketRequest request;
      request.user = AnyUser();
      request.rig_class = AnyClass();
      request.kind = random_.Chance(0.2) ? TicketKind::kJob : TicketKind::kPerson;
      if (request.kind == TicketKind::kJob) request.job = std::to_string(random_.Below(1000));
      request.min = random_.Between(Milliseconds{300'000}, Milliseconds{900'000});
      request.want = request.min + random_.Between(Milliseconds{0}, Milliseconds{1'800'000});
      Keep(scheduler_.RequestTicket(request, now_));
    } else if (dice < 0.52) {
      const TicketId id = AnyId(state.tickets);
      const auto ticket = state.tickets.find(id);
      const UserId user = ticket == state.tickets.end() ? AnyUser() : ticket->second.user;
      Keep(scheduler_.AcceptTicket(id, user, now_));
    } else if (dice < 0.54) {
      (void)scheduler_.LeaveTicket(AnyId(state.tickets), now_);
    } else if (dice < 0.62) {
      const WallTime start = now_ + random_.Between(Milliseconds{-60'000}, 4 * kHour);
      const Milliseconds length = random_.Between(Milliseconds{60'000}, kHour);
      (void)scheduler_.Book(AnyUser(), AnyClass(), {start, start + length}, now_);
    } else if (dice < 0.68) {
      const BookingId id = AnyId(state.bookings);
      const auto booking = state.bookings.find(id);
      const UserId user = booking == state.bookings.end() ? AnyUser() : booking->second.user;
      Keep(scheduler_.ClaimBooking(id, user, now_));
    } else if (dice < 0.70) {
      const BookingId id = AnyId(state.bookings);
      (void)scheduler_.CancelBooking(id, 1 + random_.Below(3), now_);
    } else if (dice < 0.74) {
      const SessionId id = AnyId(state.sessions);
      const auto reason = random_.Chance(0.5) ? EndReason::kEnded : EndReason::kOperator;
      (void)scheduler_.EndSession(id, reason, "rehearsal", now_);
    } else if (dice < 0.78) {
      const SessionId id = AnyId(state.sessions);
      if (random_.Chance(0.5)) {
        (void)scheduler_.RunStarted(id, now_);
      } else {
        (void)scheduler_.RunEnded(id, now_);
      }
    } else if (dice < 0.83) {
      const SessionId id = AnyId(state.sessions);
      const UserId to = AnyUser();
      (void)scheduler_.OfferControl(id, to, now_);
      if (random_.Chance(0.6)) Keep(scheduler_.AcceptControl(id, to, now_));
    } else if (dice < 0.84) {
      Keep(scheduler_.TakeOver(AnyId(state.sessions), AnyUser(), "rehearsal", now_));
    } else if (dice < 0.85) {
      (void)scheduler_.Extend(AnyId(state.sessions), now_);
    } else if (dice < 0.86) {
      (void)scheduler_.StillThere(AnyId(state.sessions), now_);
    } else if (dice < 0.97) {
      Command();
    } else if (dice < 0.975) {
      (void)scheduler_.RigOffline(AnyRig(), "link lost", now_);
    } else if (dice < 0.985) {
      (void)scheduler_.Claim(AnyRig(), kServer, now_);
    } else if (dice < 0.987) {
      (void)scheduler_.Quarantine(AnyRig(), "operator", now_);
      ++report_.quarantines;
    } else if (dice < 0.993) {
      (void)scheduler_.Release(AnyRig(), now_);
    } else if (dice < 0.996) {
      const WallTime start = now_ + random_.Between(Milliseconds{0}, 2 * kHour);
      (void)scheduler_.AddOutage(
          AnyRig(), {start, start + random_.Between(Milliseconds{1}, kHour)}, "works", now_);
    } else if (dice < 0.998) {
      (void)scheduler_.RemoveOutage(AnyId(state.outages), now_);
    } else if (dice < 0.9985) {
      const Milliseconds jump = random_.Chance(0.5) ? kHour : -kHour;
      now_ += jump;
      for (PendingCheck& check : checks_) check.done += jump;
      scheduler_.ClockJumped(jump);
      scheduler_.Tick(now_);
      ++report_.clock_jumps;
    } else {
      scheduler_.Tick(now_);
    }
  }

  void Keep(const core::Result<TicketAnswer>& answer) {
    if (answer.ok() && std::holds_alternative<Session>(answer.value())) {
      Remember(std::get<Session>(answer.value()));
    }
  }
  void Keep(const core::Result<Session>& session) {
    if (session.ok()) Remember(session.value());
  }
  void Remember(const Session& session) {
    if (session.epoch == 0) return;
    const Credential credential{session.rig, session.epoch, session.user, session.id};
    newest_credential_ = credential;
    if (credentials_.size() < kCredentialsKept) {
      credentials_.push_back(credential);
    } else {
      credentials_[static_cast<std::size_t>(random_.Below(Size(credentials_)))] = credential;
    }
  }

  /// A user sends a command with an epoch of any age.
  void Command() {
    if (credentials_.empty()) return;
    const bool newest = random_.Chance(0.3);
    const Credential c =
        newest ? newest_credential_
               : credentials_[static_cast<std::size_t>(random_.Below(Size(credentials_)))];
    const bool accepted = sides_[c.rig].fence.Admits(c.epoch);
    const bool stale = c.epoch < newest_[c.rig];
    if (stale) ++report_.stale_commands_tried;
    if (accepted) {
      ++report_.commands_accepted;
      if (stale) ++report_.stale_commands_accepted;
      (void)scheduler_.ControlActivity(c.session, c.epoch, now_);
    }
  }

  /// Collects the newest epoch of each rig that the scheduler has stored.
  void Observe() {
    for (const auto& [id, rig] : scheduler_.state().rigs) {
      newest_[id] = std::max(newest_[id], rig.epoch);
    }
  }

  /// Duties follow from the stored state, as in LabService.
  void Deliver() {
    Observe();
    for (const auto& [id, rig] : scheduler_.state().rigs) {
      RigSide& side = sides_[id];
      side.fence.Raise(rig.epoch);
      if (rig.status != RigStatus::kCleaning || side.last_check == rig.epoch) continue;
      side.last_check = rig.epoch;
      if (random_.Chance(0.02)) continue;  // lost result: the check must time out
      checks_.push_back({id,
                         rig.epoch,
                         now_ + random_.Between(Milliseconds{5'000}, Milliseconds{30'000}),
                         random_.Chance(0.97)});
    }
    for (const auto& [id, session] : scheduler_.state().sessions) {
      RigSide& side = sides_[session.rig];
      if (session.state != SessionState::kActive || id == side.last_session) continue;
      ++report_.sessions;
      const bool elastic = scheduler_.state().rigs.at(session.rig).elastic;
      if (!side.checked && !elastic) {
        Broken("a rig went from user to user unchecked: " + session.rig, true);
      }
      side.last_session = id;
      side.checked = false;
    }
  }

  void FinishChecks() {
    std::vector<PendingCheck> later;
    for (const PendingCheck& check : std::exchange(checks_, {})) {
      if (check.done > now_) {
        later.push_back(check);
        continue;
      }
      const auto status =
          scheduler_.CleaningDone(check.rig, check.epoch, check.passes, "rehearsal", now_);
      if (status.ok()) {
        sides_[check.rig].checked = check.passes;
        if (!check.passes) ++report_.quarantines;
      }
    }
    checks_.insert(checks_.end(), later.begin(), later.end());
  }

  void Judge() {
    std::map<RigId, int> holders;
    for (const auto& [id, session] : scheduler_.state().sessions) {
      if (session.state != SessionState::kClosed && ++holders[session.rig] > 1) {
        Broken("two holders of " + session.rig, true);
      }
    }
    const std::string broken = FindBrokenInvariant(scheduler_.state());
    if (!broken.empty()) Broken(broken, false);
  }

  void Broken(const std::string& what, bool double_allocation) {
    ++(double_allocation ? report_.double_allocations : report_.broken_invariants);
    if (report_.first_broken.empty()) {
      report_.first_broken = "step " + std::to_string(report_.steps) + ": " + what;
    }
  }

  Random random_;
  RehearsalReport& report_;
  WallTime now_ = kStart;
  Scheduler scheduler_;
  std::vector<RigId> rigs_;
  std::map<RigId, RigSide> sides_;
  std::map<RigId, std::uint64_t> newest_;
  std::vector<Credential> credentials_;
  Credential newest_credential_;
  std::vector<PendingCheck> checks_;
};

}  // namespace

void RunRandomWorlds(std::int64_t steps, std::uint64_t seed, RehearsalReport& report) {
  Random seeds(seed);
  while (report.steps < steps) {
    World world(static_cast<std::uint64_t>(seeds.Below(1LL << 62)), report);
    const std::int64_t until = std::min(steps, report.steps + kStepsPerWorld);
    while (report.steps < until) world.Step();
  }
}

}  // namespace faultlab::server::lab
