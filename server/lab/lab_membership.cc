// The membership of this process in the lab, and its clock beside those of the others.
#include <algorithm>
#include <utility>

#include "server/lab/lab_service.h"
#include "server/storage/ids.h"

namespace faultlab::server::lab {
namespace {

/// Smaller differences between the clocks are drift; larger ones mean that the clock was set.
constexpr Milliseconds kJump{2000};
/// A step of the clock that is not taken back for so long is right.
constexpr Milliseconds kBelieved = std::chrono::minutes(5);
constexpr Milliseconds kLeaseAlone = std::chrono::hours(24);
constexpr Milliseconds kLostRunLook = std::chrono::seconds(10);
/// Longest time in which a run may store its last diagnosis and its end after its rig was passed
/// on.
constexpr Milliseconds kLastWords = std::chrono::minutes(2);

}  // namespace

void LabService::NoticeClockJump() {
  const WallTime wall = clock_.Wall();
  const MonotonicTime monotonic = clock_.Monotonic();
  const auto passed = std::chrono::duration_cast<Milliseconds>(
      monotonic - std::exchange(last_monotonic_, monotonic));
  const Milliseconds jump = wall - std::exchange(last_wall_, wall) - passed;
  // Each server that shares the database would apply the same shift again; there NTP must keep the
  // clocks of the machines.
  if (store_->shared() || (jump <= kJump && jump >= -kJump)) return;
  const Milliseconds unbelieved = Milliseconds(unbelieved_ms_.load()) + jump;
  const bool set_back = unbelieved <= kJump && unbelieved >= -kJump;
  unbelieved_ms_ = set_back ? 0 : unbelieved.count();
  jumped_at_ = monotonic;
}

bool LabService::BelievesClock() const {
  return unbelieved_ms_.load() != 0 && last_monotonic_ - jumped_at_ >= kBelieved;
}

Milliseconds LabService::ClockOffset() const {
  return std::chrono::duration_cast<Milliseconds>(clock_.Wall().time_since_epoch() -
                                                  clock_.Monotonic().time_since_epoch());
}

/// Every member judges the leases, bookings and waits of all members by its own clock.
core::Status LabService::CheckClock(LabTurn& turn) {
  const Milliseconds limit = options_.clock_error_max;
  if (limit == Milliseconds{0} || !store_->shared()) return core::Done{};
  const WallTime asked = clock_.Wall();
  const WallTime theirs = turn.StoreTime();
  const Milliseconds error = asked + (clock_.Wall() - asked) / 2 - theirs;
  if (error <= limit && error >= -limit) {
    checked_offset_ = ClockOffset();
    return core::Done{};
  }
  return core::Error{core::ErrorCode::kUnavailable,
                     "this machine's clock is " + std::to_string(error.count()) +
                         " ms off the database's, and servers may differ by " +
                         std::to_string(limit.count()) + " ms; keep it by NTP",
                     "",
                     "clock_off"};
}

/// After an outage of the database every lease has ended: each member gets the time of one lease to
/// come back before the others may remove it.
bool LabService::MayRemove() {
  const MonotonicTime now = clock_.Monotonic();
  const Milliseconds lease = options_.policy.member_lease;
  if (now - last_turn_ > lease / 2) remove_from_ = now + lease;
  last_turn_ = now;
  return now >= remove_from_;
}

/// A run stores its own end; if that failed, the run would stay `running` for ever.
void LabService::InterruptLostRuns(LabTurn& turn, WallTime now) {
  const MonotonicTime looked = clock_.Monotonic();
  if (looked - last_look_ < kLostRunLook) return;
  last_look_ = looked;
  std::map<std::string, MonotonicTime> past;
  for (const std::string& run : turn.RunsOfPastLeases(options_.member, now)) {
    const auto known = past_runs_.find(run);
    const MonotonicTime since = known == past_runs_.end() ? looked : known->second;
    if (looked - since < kLastWords) {
      past.emplace(run, since);
    } else {
      turn.InterruptRun(run, now);
    }
  }
  past_runs_ = std::move(past);
}

/// The membership of this process: taken at the start, renewed at each turn, and taken again when
/// the others have removed this member because it was frozen. Members whose leases have ended are
/// removed.
core::Status LabService::KeepMembership(LabTurn& turn, Scheduler& next, Entry entry, WallTime now) {
  std::vector<Member> all = turn.Members();
  WallTime somebody_until{};
  for (const Member& each : all) somebody_until = std::max(somebody_until, each.lease_until);
  if (!all.empty() && somebody_until < now) {
    next.StoodStill(now - somebody_until);
    turn.StoodStill(somebody_until);
    use_unknown_ = true;
  }
  auto self = std::ranges::find(all, options_.member, &Member::id);
  const bool ours = self != all.end() && self->boot == boot_;
  if (!ours) {
    const bool alive =
        self != all.end() && self->lease_until > now && !(entry == Entry::kJoins && options_.alone);
    if (alive) {
      return core::Error{core::ErrorCode::kConflict,
                         "another server with server_id '" + options_.member +
                             "' uses this database; give each server an id of its own",
                         kMemberField,
                         "internal"};
    }
    if (entry == Entry::kStays) {
      next.MemberGone(options_.member, now);  // its former rigs were given up in the meantime
      const std::lock_guard lock(mutex_);
      boot_ = NewId("boot");  // what the past membership has claimed is not claimed by this one
    }
    turn.InterruptRunsOf(options_.member, now);  // runs of the previous process
    if (entry == Entry::kJoins) came_back_ = self != all.end();
    if (self == all.end()) self = all.insert(all.end(), Member{});
    *self = {options_.member, boot_, options_.address, WallTime{}};
  }
  // A busy machine may lose half of a lease.
  const Milliseconds lease = options_.alone ? kLeaseAlone : options_.policy.member_lease;
  const bool renews = self->lease_until < now + lease / 2;
  const Milliseconds moved = ClockOffset() - checked_offset_;
  const Milliseconds unnoticed = options_.clock_error_max / 2;
  if (renews || moved > unnoticed || moved < -unnoticed) {
    TRY_DONE(CheckClock(turn));
  }
  if (renews) {
    self->lease_until = now + lease;
    turn.PutMember(*self);
  }
  member_until_ = self->lease_until;
  const bool may_remove = MayRemove();
  for (auto each = all.begin(); each != all.end();) {
    if (each->id == options_.member || each->lease_until > now || !may_remove) {
      ++each;
      continue;
    }
    next.MemberGone(each->id, now);
    turn.RemoveMember(each->id, now);
    each = all.erase(each);
  }
  const std::lock_guard lock(mutex_);
  members_ = std::move(all);
  return core::Done{};
}

}  // namespace faultlab::server::lab
