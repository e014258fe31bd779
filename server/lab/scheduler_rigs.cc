// Rules 7 and 8 of the README: a rig is passed on only after a passed check; health is part of
// allocation.
#include <algorithm>

#include "server/lab/notices.h"
#include "server/lab/scheduler.h"
#include "server/lab/timeline.h"

namespace faultlab::server::lab {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

constexpr Milliseconds kLastMinute{60'000};

Error NoRig() {
  return core::Refuse("nothing_here");
}

}  // namespace

core::Status Scheduler::AddRig(const RigId& id, const std::string& rig_class, bool elastic) {
  if (id.empty() || rig_class.empty()) {
    return Error{ErrorCode::kInvalid, "a rig needs an id and a class", "id", "internal"};
  }
  const auto [entry, added] = state_.rigs.try_emplace(id);
  Rig& rig = entry->second;
  if (added) rig.reason = "not seen yet";
  rig.id = id;
  rig.rig_class = rig_class;
  rig.elastic = elastic;
  Touch(rig);
  return Done{};
}

core::Status Scheduler::Claim(const RigId& id, const std::string& server, WallTime now) {
  Rig* rig = FindRig(id);
  if (rig == nullptr) return NoRig();
  if (!rig->server.empty() && rig->server != server) {
    return core::Refuse("rig_of_other_server", "", {{"server", rig->server}});
  }
  const bool paused = rig->status == RigStatus::kOffline && now < rig->cleaning_due;
  if (paused) return Done{};  // its check was put off, because another lab holds the rig
  const bool is_new = rig->server.empty();
  rig->server = server;
  Touch(*rig);
  const bool waits = rig->status == RigStatus::kReady || rig->status == RigStatus::kCleaning;
  if (rig->status == RigStatus::kOffline || (is_new && waits)) StartCleaning(*rig, now);
  return Done{};
}

core::Status Scheduler::RenewLease(const RigId& id, WallTime now) {
  Rig* rig = FindRig(id);
  if (rig == nullptr) return NoRig();
  Session* session = LiveSessionOn(id);
  if (session == nullptr || session->state != SessionState::kActive) return Done{};
  session->epoch = ++rig->epoch;
  Touch(*rig);
  Touch(*session);
  Tick(now);
  return Done{};
}

void Scheduler::MemberGone(const std::string& server, WallTime now) {
  std::vector<RigId> theirs;
  for (const auto& [id, rig] : state_.rigs) {
    if (rig.server == server) theirs.push_back(id);
  }
  for (const RigId& id : theirs) {
    (void)RigOffline(id, "its server does not answer", now);
    FindRig(id)->server.clear();
    Touch(*FindRig(id));
  }
}

core::Status Scheduler::RigOffline(const RigId& id, const std::string& reason, WallTime now) {
  Rig* rig = FindRig(id);
  if (rig == nullptr) return NoRig();
  if (rig->status == RigStatus::kQuarantined) return Done{};
  if (rig->status == RigStatus::kOffline) {
    if (rig->reason != reason) Touch(*rig);
    rig->reason = reason;
    return Done{};
  }
  if (Session* session = LiveSessionOn(id)) {
    Close(*session, EndReason::kRigFailed, "the rig failed: " + reason, now, reason);
  }
  // The rig was only held or free until now, but its next lease needs a newer epoch all the same.
  ++rig->epoch;
  rig->status = RigStatus::kOffline;
  rig->reason = reason;
  rig->server.clear();
  rig->cleaning_due = now;
  Touch(*rig);
  Tick(now);
  return Done{};
}

core::Status Scheduler::CleaningDone(
    const RigId& id, std::uint64_t epoch, bool passed, const std::string& detail, WallTime now) {
  Rig* rig = FindRig(id);
  if (rig == nullptr) return NoRig();
  if (rig->status != RigStatus::kCleaning || rig->epoch != epoch) {
    return Error{ErrorCode::kStale, "this check is not the newest one", "", "internal"};
  }
  rig->status = passed ? RigStatus::kReady : RigStatus::kQuarantined;
  rig->reason = passed ? "" : std::string(kCheckFailedText) + detail;
  rig->check_failed = !passed;
  Touch(*rig);
  Tick(now);
  return Done{};
}

core::Status Scheduler::CheckPutOff(const RigId& id,
                                    std::uint64_t epoch,
                                    const std::string& reason,
                                    WallTime now) {
  Rig* rig = FindRig(id);
  if (rig == nullptr) return NoRig();
  if (rig->status != RigStatus::kCleaning || rig->epoch != epoch) {
    return Error{ErrorCode::kStale, "this check is not the newest one", "", "internal"};
  }
  const core::Status offline = RigOffline(id, reason, now);
  rig->cleaning_due = now + policy_.check_pause;
  return offline;
}

core::Status Scheduler::Quarantine(const RigId& id, const std::string& reason, WallTime now) {
  Rig* rig = FindRig(id);
  if (rig == nullptr) return NoRig();
  if (Session* session = LiveSessionOn(id)) {
    Close(*session, EndReason::kRigFailed, "the rig was taken out: " + reason, now, reason);
  }
  ++rig->epoch;
  rig->status = RigStatus::kQuarantined;
  rig->reason = reason;
  rig->check_failed = false;
  Touch(*rig);
  Tick(now);
  return Done{};
}

core::Status Scheduler::Release(const RigId& id, WallTime now) {
  Rig* rig = FindRig(id);
  if (rig == nullptr) return NoRig();
  if (rig->status != RigStatus::kQuarantined) {
    return core::Refuse("not_quarantined", "", {{"state", Name(rig->status)}});
  }
  StartCleaning(*rig, now);
  return Done{};
}

core::Status Scheduler::Recheck(const RigId& id, WallTime now) {
  Rig* rig = FindRig(id);
  if (rig == nullptr) return NoRig();
  if (rig->status != RigStatus::kReady) {
    return core::Refuse("not_ready", "", {{"state", Name(rig->status)}});
  }
  StartCleaning(*rig, now);
  return Done{};
}

core::Status Scheduler::Adopt(const RigId& id, std::uint64_t seen, WallTime now) {
  Rig* rig = FindRig(id);
  if (rig == nullptr) return NoRig();
  const bool behind = seen > rig->epoch;
  if (!behind && rig->status != RigStatus::kQuarantined) {
    return core::Refuse("no_adoption_needed", "", {{"seen", seen}, {"epoch", rig->epoch}});
  }
  if (Session* session = LiveSessionOn(id)) {
    Close(*session, EndReason::kRigFailed, "the rig was adopted anew", now);
  }
  rig->epoch = std::max(rig->epoch, seen);
  StartCleaning(*rig, now);
  Tick(now);
  return Done{};
}

core::Result<Outage> Scheduler::AddOutage(const RigId& id,
                                          const Interval& during,
                                          const std::string& reason,
                                          WallTime now) {
  if (FindRig(id) == nullptr) return NoRig();
  if (during.end <= during.start) {
    return core::Refuse("end_before_start", "end");
  }
  if (during.end <= now) return core::Refuse("outage_past", "end");
  if (during.end > now + policy_.booking_ahead) {
    return core::Refuse("outage_too_far", "end");
  }
  for (const auto& [known_id, known] : state_.outages) {
    if (known.rig == id && known.during.start <= during.start && during.end <= known.during.end) {
      return core::Refuse("outage_planned", "start");
    }
  }
  Outage outage{OutageId{NewNumber()}, id, during, reason, ""};
  state_.outages[outage.id] = outage;
  touched_outages_.insert(outage.id);
  if (Session* session = LiveSessionOn(id)) {
    const WallTime latest = std::max(now + kLastMinute, during.start - policy_.cleaning);
    if (session->hard_end > latest && during.start < session->hard_end + policy_.cleaning) {
      session->hard_end = latest;
      session->warning_stage = WarningStage(latest - now);  // this is the warning, too
      Touch(*session);
      Notify({session->user,
              session->id,
              "shortened",
              LeftText(latest - now) + ": planned outage: " + reason,
              session->rig,
              {},
              reason,
              "outage",
              latest});
    }
  }
  // Bookings in this time move now; if one cannot move, its user is told now.
  for (auto& [booking_id, booking] : state_.bookings) {
    if (booking.state != BookingState::kBooked || booking.rig != id) continue;
    if (!booking.during.Overlaps(during)) continue;
    const Rig* other = FindFreeRig(
        state_, booking.rig_class, booking.during, now, policy_, booking.rig, booking_id);
    if (other == nullptr) {
      Unfulfil(booking, "outage", reason);
      outage.fallen += WriteFallen(booking);
    } else if (other->id != booking.rig) {
      booking.rig = other->id;
      ++booking.version;
      Touch(booking);
      TellMoved(booking, "outage", reason);
    }
  }
  state_.outages[outage.id] = outage;
  Tick(now);
  return outage;
}

core::Status Scheduler::RemoveOutage(OutageId id, WallTime now) {
  const auto found = state_.outages.find(id);
  if (found == state_.outages.end()) {
    return core::Refuse("no_outage");
  }
  const Outage outage = found->second;
  state_.outages.erase(found);
  touched_outages_.erase(id);
  ended_outages_.push_back(id);
  Tick(now);  // somebody may have waited for the time
  for (const auto& [user, during] : ReadFallen(outage)) {
    if (during.start <= now) continue;
    const Interval& time = during;
    const bool given = std::ranges::any_of(state_.bookings, [&](const auto& each) {
      const Booking& other = each.second;
      return other.state == BookingState::kBooked && other.rig == outage.rig &&
             other.during.Overlaps(time);
    });
    if (given) continue;
    Notify({user,
            {},
            "freed",
            "the planned outage is called off: the time of your booking from " +
                UtcText(during.start) + " can be booked again",
            outage.rig,
            {},
            "",
            "",
            during.start});
  }
  return Done{};
}

void Scheduler::TickRigs(WallTime now) {
  for (auto entry = state_.outages.begin(); entry != state_.outages.end();) {
    if (entry->second.during.end <= now) {
      touched_outages_.erase(entry->first);
      ended_outages_.push_back(entry->first);
      entry = state_.outages.erase(entry);
    } else {
      ++entry;
    }
  }
  for (auto& [id, rig] : state_.rigs) {
    const auto outage =
        std::find_if(state_.outages.begin(), state_.outages.end(), [&, &id = id](const auto& o) {
          return o.second.rig == id && o.second.during.start <= now;
        });
    const bool out = outage != state_.outages.end();
    if (rig.status == RigStatus::kCleaning && now >= rig.cleaning_due) {
      rig.status = RigStatus::kQuarantined;
      rig.reason = "the check between users did not end in time";
      rig.check_failed = false;
      Touch(rig);
    } else if (rig.status == RigStatus::kReady && out) {
      ToMaintenance(rig, outage->second.reason);
    } else if (rig.status == RigStatus::kMaintenance && !out) {
      StartCleaning(rig, now);
    }
  }
}

}  // namespace faultlab::server::lab
