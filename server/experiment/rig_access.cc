#include "server/experiment/rig_access.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/lab/timeline.h"
#include "server/run/refusals.h"

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;

/// Of a practice lease, beyond twice its run: a busy machine may play it slower than planned.
constexpr milliseconds kPracticeMargin = std::chrono::minutes(10);
/// So many times faster than time the run of a job is played at least, on a simulator.
constexpr int kJobsFaster = 50;

/// The active session on this rig that is the caller's.
const lab::Session* SessionOf(const lab::LabState& state,
                              const Principal& who,
                              StartedBy by,
                              const std::string& rig) {
  for (const auto& [id, session] : state.sessions) {
    if (session.state != lab::SessionState::kActive || session.rig != rig) continue;
    if (session.user != lab::UserId{who.user_id}) continue;
    // The session of a job is for its run alone.
    const bool job = by == StartedBy::kJob;
    if (session.kind == (job ? lab::TicketKind::kJob : lab::TicketKind::kPerson)) return &session;
  }
  return nullptr;
}

milliseconds PracticeFor(milliseconds run) {
  return 2 * run + kPracticeMargin;
}

/// Simulators on which a run of this length may begin now.
std::size_t FreeAmong(const std::vector<lab::RigId>& simulators,
                      milliseconds length,
                      const lab::LabState& state,
                      WallTime now) {
  return static_cast<std::size_t>(std::ranges::count_if(simulators, [&](const lab::RigId& id) {
    return lab::IsFreeForPractice(state, id, PracticeFor(length), now);
  }));
}

/// Until the run after `before` others can begin: by the planned ends of the runs that go on, and
/// as if those that follow took as long as they do.
std::chrono::seconds WaitOf(std::size_t before,
                            const std::vector<lab::RigId>& simulators,
                            const lab::LabState& state,
                            WallTime now) {
  std::vector<milliseconds> left;
  milliseconds lengths{0};
  for (const auto& [id, session] : state.sessions) {
    if (session.kind != lab::TicketKind::kPractice ||
        std::ranges::find(simulators, session.rig) == simulators.end()) {
      continue;
    }
    const milliseconds length = (session.hard_end - session.start - kPracticeMargin) / 2;
    lengths += length;
    left.push_back(std::max(milliseconds{0}, session.start + length - now));
  }
  if (left.empty()) return std::chrono::seconds{1};
  std::ranges::sort(left);
  const auto count = static_cast<std::int64_t>(left.size());
  const auto turns = static_cast<std::int64_t>(before);
  const milliseconds wait =
      left[static_cast<std::size_t>(turns % count)] + (turns / count) * (lengths / count);
  return std::chrono::ceil<std::chrono::seconds>(wait);
}

}  // namespace

bool NeedsSession(const RigStatus& rig) {
  return rig.description.kind == hardware::RigKind::kBench ||
         rig.description.kind == hardware::RigKind::kRemote;
}

bool IsKnown(const lab::LabService& service, const RigPool& rig_pool, const std::string& rig) {
  return service.state()->rigs.contains(rig) || rig_pool.Find(rig).ok();
}

core::Result<const core::Bench*> BenchOfRig(const RigPool& rig_pool,
                                            Benches& benches,
                                            const std::string& rig) {
  const auto here = rig_pool.Find(rig);
  if (here.ok()) return here.value().description.bench;
  return benches.OfRig(rig);
}

RigAccess::RigAccess(lab::LabService& service,
                     RigPool& rig_pool,
                     const Clock& clock,
                     std::function<void(std::string_view)> log)
    : service_(service), rig_pool_(rig_pool), clock_(clock), log_(std::move(log)) {
  rig_pool_.OnRelease([this](const lab::Lease& lease) { EndPractice(lease); });
}

RigAccess::~RigAccess() {
  rig_pool_.OnRelease({});
}

bool RigAccess::MayCommand(const Principal& who, const std::string& rig) const {
  const auto found = rig_pool_.Find(rig);
  if (rig.empty() || !found.ok() || !NeedsSession(found.value())) return true;
  return SessionOf(*service_.state(), who, StartedBy::kPerson, rig) != nullptr;
}

bool RigAccess::IsKnownElsewhere(const std::string& rig) const {
  const auto member = service_.MemberOf(rig);
  return member && member->id != service_.member();
}

/// A rig of the lab of which this server hears the name only, as when its key is gone.
std::optional<core::Error> RigAccess::RefusalOfStranger(const std::string& rig) const {
  for (const RigStatus& stranger : rig_pool_.ListUnprovenRigs()) {
    const bool named = stranger.description.id == rig && stranger.remote;
    if (named && stranger.remote->refusal) return refusal::RigRefused(rig, *stranger.remote);
  }
  return std::nullopt;
}

std::vector<lab::RigId> RigAccess::SimulatorsOf(const core::Bench& bench) const {
  std::vector<lab::RigId> simulators;
  std::vector<lab::RigId> let_go_soon;  // its lease has ended, its run has not let go of it yet
  for (const RigStatus& each : rig_pool_.List()) {
    if (NeedsSession(each) || each.description.bench != &bench) continue;
    (each.leased ? let_go_soon : simulators).push_back(each.description.id);
  }
  simulators.insert(simulators.end(), let_go_soon.begin(), let_go_soon.end());
  return simulators;
}

core::Status RigAccess::CheckTurn(const Principal& who,
                                  const std::string& bench,
                                  const std::vector<lab::RigId>& simulators,
                                  milliseconds length,
                                  const lab::LabState& state,
                                  WallTime now) {
  const bool possible = std::ranges::any_of(simulators, [&](const lab::RigId& id) {
    return lab::NextCommitment(state, id, now) >= now + PracticeFor(length);
  });
  if (!possible) {  // nobody waits in line for what cannot come
    line_.Leave(bench, who.caller_key());
    return core::Refuse("simulators_planned", "/rig");
  }
  const std::size_t before = line_.Ask(bench, who.caller_key(), clock_.Monotonic());
  const std::size_t free = FreeAmong(simulators, length, state, now);
  if (before < free) return core::Done{};
  return core::Refuse("in_line",
                      "/rig",
                      {{"place", before + 1},
                       {"seconds", WaitOf(before - free, simulators, state, now).count()},
                       {"again_s", WaitingLine::AgainAfter(before).count()}});
}

core::Status RigAccess::AwaitTurn(const Principal& who,
                                  const core::Bench& bench,
                                  milliseconds length) {
  const std::vector<lab::RigId> simulators = SimulatorsOf(bench);
  if (simulators.empty()) return core::Done{};  // whoever asks for one is told so
  const auto state = service_.state();
  return CheckTurn(who, bench.name, simulators, length, *state, service_.Now());
}

void RigAccess::LeaveLine(const Principal& who, const core::Bench& bench) {
  line_.Leave(bench.name, who.caller_key());
}

/// The lease by the newest stored state, which the service has fenced the pool with before it
/// answers.
core::Result<lab::Lease> RigAccess::LeaseFor(const Principal& who,
                                             StartedBy by,
                                             const std::string& rig,
                                             const core::Bench& bench,
                                             milliseconds length) {
  const std::vector<lab::RigId> all = SimulatorsOf(bench);
  std::vector<lab::RigId> simulators;
  if (rig.empty()) {
    simulators = all;
  } else {
    const auto found = rig_pool_.Find(rig);
    if (!found && service_.state()->rigs.contains(rig)) {
      const auto refused = RefusalOfStranger(rig);
      return refused ? *refused : core::Refuse("rig_away", "/rig", {{"rig", rig}});
    }
    if (!found) return found.error();
    const auto& remote = found.value().remote;
    if (remote && remote->refusal) return refusal::RigRefused(rig, *remote);
    if (!NeedsSession(found.value())) simulators.push_back(rig);
  }
  const bool lines_up = rig.empty() && by == StartedBy::kPerson;
  const milliseconds played = by == StartedBy::kJob ? length / kJobsFaster : length;
  return service_.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Result<lab::Lease> {
    const lab::LabState& state = scheduler.state();
    if (const lab::Session* own = SessionOf(state, who, by, rig)) {
      const std::string& server = state.rigs.at(rig).server;
      if (server == service_.member()) return lab::LeaseOf(*own);
      return core::Refuse("rig_elsewhere", "/rig", {{"rig", rig}, {"member", server}});
    }
    if (!simulators.empty()) {
      TRY_DONE(lines_up ? CheckTurn(who, bench.name, simulators, length, state, now)
                        : core::Status(core::Done{}));
      const std::size_t awaited = lines_up ? 0 : line_.Length(bench.name, clock_.Monotonic());
      const bool left_over = awaited == 0 || FreeAmong(all, length, state, now) > awaited;
      TRY(auto session,
          scheduler.Practice(lab::UserId{who.user_id},
                             left_over ? simulators : std::vector<lab::RigId>{},
                             PracticeFor(played),
                             now));
      return lab::LeaseOf(session);
    }
    if (rig.empty()) {
      return core::Refuse("no_simulator", "/bench", {{"bench", bench.name}});
    }
    if (!state.rigs.contains(rig)) {
      return core::Refuse("rig_just_found", "/rig", {{"rig", rig}});
    }
    return core::Refuse("rig_needs_session", "/rig", {{"rig", rig}});
  });
}

core::Result<RigHandle> RigAccess::Hold(const Principal& who,
                                        StartedBy by,
                                        const std::string& rig,
                                        const core::Bench& bench,
                                        milliseconds length) {
  TRY(const auto lease, LeaseFor(who, by, rig, bench, length));
  // A person watches; a job has somebody wait for all of its runs.
  auto hold = rig_pool_.Acquire(
      lease, RigPool::kPatience, by == StartedBy::kJob ? Pace::kFastest : Pace::kOfRig);
  if (!hold) EndPractice(lease);
  return hold;
}

/// Practice is over when its run has let go of the rig.
void RigAccess::EndPractice(const lab::Lease& lease) {
  const auto state = service_.state();
  const auto session = state->sessions.find(lease.session);
  const bool practice =
      session != state->sessions.end() && session->second.kind == lab::TicketKind::kPractice;
  if (!practice) return;
  const core::Status ended =
      service_.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
        scheduler.EndPractice(lease.session, now);
        return core::Done{};
      });
  // It ends by its own time then.
  if (!ended.ok()) log_("lab: practice on " + lease.rig + ": " + ended.error().message);
}

}  // namespace faultlab::server
