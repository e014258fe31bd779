#include "server/upkeep/roll_call.h"

#include <algorithm>
#include <utility>

#include "server/experiment/rig_access.h"

namespace faultlab::server {
namespace {

using std::chrono::seconds;

/// After the start: agents are heard one after the other.
constexpr seconds kHearingTime{5};
/// Somebody's session outlives this silence of its rig: a network that stumbles, an agent or a
/// server that starts again. Counted from the first look that does not hear it.
constexpr seconds kSilenceForgiven{20};

}  // namespace

RollCall::RollCall(lab::LabService& lab,
                   const Clock& clock,
                   std::function<void(std::string_view)> log)
    : lab_(lab),
      clock_(clock),
      log_(std::move(log)),
      heard_from_(clock.Monotonic() + kHearingTime) {}

/// Rigs that this server had before its last start and has no longer, as after a change of its
/// settings. They are claimed again when they appear.
std::vector<lab::RigId> RollCall::FindGone(const lab::LabState& state,
                                           const std::vector<RigStatus>& rigs) {
  std::vector<lab::RigId> gone;
  for (const auto& [id, rig] : state.rigs) {
    const bool out =
        rig.status == lab::RigStatus::kOffline || rig.status == lab::RigStatus::kQuarantined;
    if (rig.server != lab_.member() || out) continue;
    const bool here = std::ranges::any_of(
        rigs, [&id = id](const RigStatus& each) { return each.description.id == id; });
    if (here) continue;
    if (rig.elastic || (!IsAwaited(state, id) && AllHeard())) gone.push_back(id);
  }
  return gone;
}

/// Whether somebody's session waits for a rig that is not heard. (One that is only offered is
/// offered on another rig.)
bool RollCall::IsAwaited(const lab::LabState& state, const lab::RigId& silent) {
  const MonotonicTime now = clock_.Monotonic();
  const MonotonicTime since = silent_since_.try_emplace(silent, now).first->second;
  const bool in_session = std::ranges::any_of(state.sessions, [&](const auto& entry) {
    return entry.second.rig == silent && entry.second.state == lab::SessionState::kActive;
  });
  return in_session && now < since + kSilenceForgiven;
}

std::vector<RollCall::Change> RollCall::FindChanges(const lab::LabState& state,
                                                    std::vector<RigStatus> rigs) {
  std::vector<Change> changes;
  const ClassBenches benches = BenchesOfClasses(rigs, state, lab_.member());
  for (RigStatus& rig : rigs) {
    const auto known = state.rigs.find(rig.description.id);
    const bool is_new = known == state.rigs.end();
    const std::string owner = is_new ? "" : known->second.server;
    if (!owner.empty() && owner != lab_.member()) continue;  // another member has it
    // An agent whose messages cannot be read has not described its rig.
    const bool described = !rig.description.rig_class.empty();
    if (is_new && !described) continue;
    const bool is_other = !is_new && described &&
                          (known->second.rig_class != rig.description.rig_class ||
                           known->second.elastic == NeedsSession(rig));
    std::string why = WhyOffline(rig, benches);
    // One whose messages cannot be read is not silent.
    const bool is_silent =
        rig.remote && rig.remote->link == hardware::LinkState::kLost && !rig.remote->refusal;
    if (!is_silent) silent_since_.erase(rig.description.id);
    if (is_silent && IsAwaited(state, rig.description.id)) continue;
    const bool known_offline = is_new || known->second.status == lab::RigStatus::kOffline;
    const bool unclaimed = owner.empty() && why.empty();
    const bool other_reason =
        known_offline && !why.empty() && (is_new || known->second.reason != why);
    if (is_new || is_other || unclaimed || !why.empty() != known_offline || other_reason) {
      changes.push_back({std::move(rig), std::move(why), is_new || is_other});
    }
  }
  return changes;
}

void RollCall::Take(std::vector<RigStatus> rigs) {
  const auto state = lab_.state();
  const std::vector<lab::RigId> gone = FindGone(*state, rigs);
  const std::vector<Change> changes = FindChanges(*state, std::move(rigs));
  if (changes.empty() && gone.empty()) return;
  const core::Status told = lab_.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
    for (const lab::RigId& id : gone) {
      if (scheduler.state().rigs.at(id).server != lab_.member()) continue;
      (void)scheduler.RigOffline(id, "this server has no such rig now", now);
    }
    for (const auto& [rig, why, describe] : changes) {
      const std::string& id = rig.description.id;
      core::Status done = core::Done{};
      if (describe) done = scheduler.AddRig(id, rig.description.rig_class, !NeedsSession(rig));
      if (done.ok()) {
        done = why.empty() ? scheduler.Claim(id, lab_.member(), now)
                           : scheduler.RigOffline(id, why, now);
      }
      if (!done.ok()) log_("lab: rig " + id + ": " + done.error().message);
    }
    return core::Done{};
  });
  if (!told.ok()) log_("lab: " + told.error().message);
}

}  // namespace faultlab::server
