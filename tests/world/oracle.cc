// What is told and shown, and what rigs accept.
#include "tests/world/oracle.h"

#include <algorithm>
#include <utility>

#include "tests/world/published_rules.h"

namespace faultlab::server::lab::rehearsal {
void Oracle::Broken(const std::string& rule, const std::string& text) {
  Findings& findings = findings_[rule];
  if (findings.count++ == 0) findings.first = text;
}

void Oracle::Trouble(WorldTime until) {
  trouble_until_ = std::max(trouble_until_, until);
}

void Oracle::RigTrouble(const std::string& rig_class, WorldTime at) {
  rig_trouble_[rig_class] = at;
}

bool Oracle::RigsExcused(const std::string& rig_class, WorldTime at) const {
  if (Excused(at) || (clock_set_ && at - *clock_set_ < kPlansLast)) return true;
  const auto found = rig_trouble_.find(rig_class);
  return found != rig_trouble_.end() && at - found->second < kPlansLast;
}

void Oracle::Told(const std::vector<LabEvent>& messages, WorldTime at) {
  static const std::set<std::string> kEnds = {"ended",
                                              "expired",
                                              "idle_ended",
                                              "no_show",
                                              "offer_missed",
                                              "rig_failed",
                                              "operator",
                                              "booking_elsewhere"};
  for (const LabEvent& message : messages) {
    const auto known = known_.find(message.session);
    if (message.topic == "idle") {  // the question
      if (known != known_.end()) known->second.idle_asked = at;
    } else if (kEnds.contains(message.topic)) {
      end_topics_[message.session] = message.topic;
      end_texts_[message.session] = message.text;
    } else if (message.topic == "warning") {
      if (known != known_.end()) known->second.warned = true;
    } else if (message.topic == "extended") {
      told_extended_.insert(message.session);
    } else if (message.topic == "shortened") {
      told_shortened_.insert(message.session);
    } else if (message.topic == "unfulfilled") {
      ++told_unfulfilled_[message.user];
    } else if (message.topic == "time_free" || message.topic == "time_not_free") {
      ++told_time_[message.user];
    }
  }
}

void Oracle::Shown(const Published& now, const Moment& moment) {
  ++answers_;
  for (const auto& [id, rig] : now.rigs) {
    const bool unwell = rig.status == RigStatus::kOffline ||
                        rig.status == RigStatus::kQuarantined ||
                        rig.status == RigStatus::kMaintenance;
    if (unwell) rig_trouble_[rig.rig_class] = moment.at;
  }
  for (const auto& [id, outage] : now.outages) {
    rig_trouble_[now.rigs.at(outage.rig).rig_class] = moment.at;
  }
  std::erase_if(just_over_, [&](const auto& over) {
    Lease& lease = leases_[over.first][over.second];
    lease.known_to.try_emplace(moment.member, answers_);
    return moment.at - *lease.over > kRemembered;
  });
  JudgeSessions(now, moment);
  JudgeRigs(now, moment);
  JudgeWaiting(now, moment);
  JudgeBookings(now, moment);
  JudgeOrder(now, moment);
  JudgeTickets(now, moment);
  told_extended_.clear();
  told_shortened_.clear();
  asked_to_extend_.clear();
  answered_[moment.member] = last_answer_ = moment.at;
}

void Oracle::JudgeRigs(const Published& now, const Moment& moment) {
  for (const auto& [id, rig] : now.rigs) {
    KnownRig& known = rigs_[id];
    if (rig.status != known.status || rig.epoch != known.epoch) {
      const bool late = known.status == RigStatus::kCleaning &&
                        moment.at - known.status_since > kCleaningLongest - kChunkLongest;
      if (rig.status == RigStatus::kQuarantined && !known.failed && !late) {
        Broken("health", id + " is in quarantine though no check failed: " + rig.reason);
      }
      if (rig.status != RigStatus::kQuarantined) known.failed = false;
      known.status = rig.status;
      known.epoch = rig.epoch;
      known.status_since = moment.at;
    }
    const bool long_checked = rig.status == RigStatus::kCleaning &&
                              moment.at - known.status_since > kCleaningLongest + kChunkLongest;
    if (long_checked && !Excused(moment.at)) {
      Broken("check between users", id + " is checked for ever");
      known.status_since = moment.at;
    }
    const bool unchecked = !rig.elastic && !rigs_[id].checked;
    if (rig.status == RigStatus::kReady && unchecked) {
      Broken("check between users", id + " is shown as ready without a passed check");
      rigs_[id].checked = true;  // one finding
    }
  }
}

void Oracle::Active(SessionId session, WorldTime at) {
  const auto known = known_.find(session);
  if (known == known_.end()) return;
  known->second.last_activity = at;
  known->second.idle_asked.reset();
}

void Oracle::RunEnded(SessionId session, WorldTime at) {
  --runs_[session];
  Active(session, at);
}

void Oracle::CheckBegan(const RigId& id, std::uint64_t epoch, WorldTime) {
  KnownRig& rig = rigs_[id];
  const bool again = epoch == rig.newest_check;
  if (epoch < rig.highest_lease || (epoch == rig.highest_lease && !again)) {
    Broken("epochs rise",
           "the check of " + id + " has epoch " + std::to_string(epoch) + " after " +
               std::to_string(rig.highest_lease));
  }
  for (const auto& [session, known] : known_) {
    if (known.last.rig == id && known.last.state == SessionState::kActive) {
      Broken("check between users",
             id + " is checked while " + "session " + std::to_string(Number(session)) + " has it");
    }
  }
  rig.highest_lease = std::max(rig.highest_lease, epoch);
  rig.newest_check = epoch;
  if (!again) rig.checked = false;  // else its result may have been stored already
}

void Oracle::CheckEnded(const RigId& id, std::uint64_t epoch, bool passed, WorldTime) {
  KnownRig& rig = rigs_[id];
  if (epoch == rig.newest_check) rig.checked = passed;
  if (!passed) rig.failed = true;
}

void Oracle::Accepted(const RigId& rig, std::uint64_t epoch, const Sender& sender) {
  const auto lease = leases_[rig].find(epoch);
  if (lease == leases_[rig].end()) {
    return Broken("stale command", rig + " accepted a command of an unknown lease");
  }
  if (lease->second.user != sender.user) {
    Broken("stale command", rig + " accepted a command of somebody without the control");
  }
  if (shared_ && sender.sent - answered_[sender.member] > kMemberLease + kSlack) {
    Broken("member's lease", sender.member + " commanded " + rig + " after its lease had ended");
  }
  if (!lease->second.over) return;
  const auto known = lease->second.known_to.find(sender.member);
  const bool knew = known != lease->second.known_to.end() && sender.after >= known->second;
  if (knew || sender.sent - *lease->second.over > kMemberLease + kSlack) {
    Broken("stale command",
           rig + " accepted epoch " + std::to_string(epoch) + " after its session had ended");
  }
}

}  // namespace faultlab::server::lab::rehearsal
