#include "server/app/rig_upkeep.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/app/rig_classes.h"
#include "server/experiment/rig_access.h"
#include "server/storage/database_error.h"

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kRigPatience = seconds(20);  ///< until the last run has released the rig
/// A check is three seconds of waiting for the rig: all rigs of a laboratory are ready after those.
constexpr int kChecksAtOnce = 16;
/// After the start: agents are heard one after the other.
constexpr seconds kHearingTime{5};
/// Somebody's session outlives this silence of its rig: a network that stumbles, an agent or a
/// server that starts again. Counted from the first look that does not hear it.
constexpr seconds kSilenceForgiven{20};

/// If the rig does not answer yet, or the database is away, the rig's health is unknown.
lab::RigVerdict NotBegun(const core::Error& error) {
  lab::RigVerdict verdict = lab::VerdictOf(error);
  verdict.put_off = verdict.put_off || error.code == core::ErrorCode::kNotFound ||
                    error.code == core::ErrorCode::kUnavailable;
  return verdict;
}

/// The database takes nothing now: another try may succeed.
bool IsNotStored(const core::Error& error) {
  return error.code == core::ErrorCode::kBusy || error.code == core::ErrorCode::kUnavailable;
}

std::string KindOf(const std::set<CheckExtra>& extras) {
  if (extras.contains(CheckExtra::kCommission)) return "commission";
  if (extras.contains(CheckExtra::kClearTrip)) return "clear_trip";
  if (extras.contains(CheckExtra::kContacts)) return "self_test";
  return "between_users";
}

}  // namespace

RigUpkeep::RigUpkeep(RigPool& rig_pool,
                     lab::RigBands& bands,
                     lab::CheckLog& check_log,
                     Benches& benches,
                     const Clock& clock,
                     std::function<void(std::string_view)> log,
                     milliseconds follow)
    : rig_pool_(rig_pool),
      bands_(bands),
      check_log_(check_log),
      benches_(benches),
      clock_(clock),
      log_(std::move(log)),
      follow_(follow) {}

RigUpkeep::~RigUpkeep() {
  Stop();
}

void RigUpkeep::Start(lab::LabService& service) {
  service_ = &service;
  heard_from_ = clock_.Monotonic() + kHearingTime;
  FollowRigs();
  for (int i = 0; i < kChecksAtOnce; ++i) threads_.emplace_back([this] { CheckLoop(); });
  threads_.emplace_back([this] {
    while (!WaitForStop(follow_)) FollowRigs();
  });
}

void RigUpkeep::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

void RigUpkeep::WithNextCheck(const std::string& rig, CheckExtra extra) {
  const std::lock_guard lock(mutex_);
  extras_[rig].insert(extra);
}

std::optional<RigContacts> RigUpkeep::ContactsOf(const std::string& rig) const {
  const std::lock_guard lock(mutex_);
  const auto found = contacts_.find(rig);
  if (found == contacts_.end()) return std::nullopt;
  return found->second;
}

void RigUpkeep::Fence(const lab::RigId& rig, std::uint64_t epoch) {
  rig_pool_.Fence(rig, epoch);
}

void RigUpkeep::StartCleaning(const lab::Lease& lease) {
  {
    const std::lock_guard lock(mutex_);
    // After an outage of the database the lab asks again, although the check may still go on.
    if (!checking_.emplace(lease.rig, lease.epoch).second) return;
    checks_.push_back(lease);
  }
  wake_.notify_all();
}

bool RigUpkeep::RunInProgress(const lab::RigId& rig) {
  return rig_pool_.Holds(rig);
}

bool RigUpkeep::WaitForStop(milliseconds patience) {
  std::unique_lock lock(mutex_);
  return wake_.wait_for(lock, patience, [&] { return stopping_; });
}

/// A rig of the same name that is built otherwise has no norm yet, and was checked and promised to
/// its session as something else.
void RigUpkeep::FollowBenches(const std::vector<RigStatus>& rigs) {
  std::map<std::string, const core::Bench*> changed;
  for (const RigStatus& rig : rigs) {
    const core::Bench* bench = rig.description.bench;
    const auto stored = stored_benches_.find(rig.description.id);
    if (bench == nullptr) continue;
    if (stored == stored_benches_.end() || stored->second != bench) {
      changed[rig.description.id] = bench;
    }
  }
  if (!changed.empty()) {
    const auto others = benches_.PutRigs(changed, clock_.Wall());
    if (!others.ok()) return log_("lab: what rigs are built like: " + others.error().message);
    rebuilt_.insert(others.value().begin(), others.value().end());
    for (const auto& [rig, bench] : changed) stored_benches_[rig] = bench;
  }
  while (!rebuilt_.empty()) {
    const std::string rig = *rebuilt_.begin();
    core::Status done = bands_.Forget(rig);
    if (done.ok()) {
      done = service_->Do([&](lab::Scheduler& scheduler, WallTime now) {
        return scheduler.RigOffline(rig, "it is another bench now", now);
      });
    }
    const bool is_new = !done.ok() && done.error().code == core::ErrorCode::kNotFound;
    if (!done.ok() && !is_new) return log_("lab: rig " + rig + ": " + done.error().message);
    rebuilt_.erase(rig);
  }
}

/// Rigs that this server had before its last start and has no longer, as after a change of its
/// settings. They are claimed again when they appear.
std::vector<lab::RigId> RigUpkeep::FindGone(const lab::LabState& state,
                                            const std::vector<RigStatus>& rigs) {
  const bool all_heard = clock_.Monotonic() >= heard_from_;
  std::vector<lab::RigId> gone;
  for (const auto& [id, rig] : state.rigs) {
    const bool out =
        rig.status == lab::RigStatus::kOffline || rig.status == lab::RigStatus::kQuarantined;
    if (rig.server != service_->member() || out) continue;
    const bool here = std::ranges::any_of(
        rigs, [&id = id](const RigStatus& each) { return each.description.id == id; });
    if (here) continue;
    if (rig.elastic || (!IsAwaited(state, id) && all_heard)) gone.push_back(id);
  }
  return gone;
}

/// Whether somebody's session waits for a rig that is not heard. (One that is only offered is
/// offered on another rig.)
bool RigUpkeep::IsAwaited(const lab::LabState& state, const lab::RigId& silent) {
  const MonotonicTime now = clock_.Monotonic();
  const MonotonicTime since = silent_since_.try_emplace(silent, now).first->second;
  const bool in_session = std::ranges::any_of(state.sessions, [&](const auto& entry) {
    return entry.second.rig == silent && entry.second.state == lab::SessionState::kActive;
  });
  return in_session && now < since + kSilenceForgiven;
}

/// Rigs come and go: the scheduler learns it here, and cleans what has come.
void RigUpkeep::FollowRigs() {
  struct Change {
    RigStatus rig;
    std::string why;        ///< it is offline; empty: it can be used
    bool describe = false;  ///< the lab does not know the rig, or has another description of it
  };
  std::vector<Change> changes;
  std::vector<RigStatus> rigs = rig_pool_.List();
  FollowBenches(rigs);
  const auto state = service_->state();
  const std::vector<lab::RigId> gone = FindGone(*state, rigs);
  const ClassBenches benches = BenchesOfClasses(rigs, *state, service_->member());
  for (RigStatus& rig : rigs) {
    const auto known = state->rigs.find(rig.description.id);
    const bool is_new = known == state->rigs.end();
    const std::string owner = is_new ? "" : known->second.server;
    if (!owner.empty() && owner != service_->member()) continue;  // another member has it
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
    if (is_silent && IsAwaited(*state, rig.description.id)) continue;
    const bool known_offline = is_new || known->second.status == lab::RigStatus::kOffline;
    const bool unclaimed = owner.empty() && why.empty();
    const bool other_reason =
        known_offline && !why.empty() && (is_new || known->second.reason != why);
    if (is_new || is_other || unclaimed || !why.empty() != known_offline || other_reason) {
      changes.push_back({std::move(rig), std::move(why), is_new || is_other});
    }
  }
  if (changes.empty() && gone.empty()) return;
  const core::Status told =
      service_->Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
        for (const lab::RigId& id : gone) {
          if (scheduler.state().rigs.at(id).server != service_->member()) continue;
          (void)scheduler.RigOffline(id, "this server has no such rig now", now);
        }
        for (const auto& [rig, why, describe] : changes) {
          const std::string& id = rig.description.id;
          core::Status done = core::Done{};
          if (describe) done = scheduler.AddRig(id, rig.description.rig_class, !NeedsSession(rig));
          if (done.ok()) {
            done = why.empty() ? scheduler.Claim(id, service_->member(), now)
                               : scheduler.RigOffline(id, why, now);
          }
          if (!done.ok()) log_("lab: rig " + id + ": " + done.error().message);
        }
        return core::Done{};
      });
  if (!told.ok()) log_("lab: " + told.error().message);
}

void RigUpkeep::CheckLoop() {
  while (true) {
    lab::Lease lease;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopping_ || !checks_.empty(); });
      if (stopping_) return;
      lease = std::move(checks_.front());
      checks_.pop_front();
    }
    std::string kind;
    const lab::RigVerdict verdict = Check(lease, kind);
    // Before the rig is free: who sees that a check has ended finds it in the list.
    if (!verdict.put_off) LogCheck(lease.rig, kind, verdict);
    TellVerdict(lease, verdict);
    {
      const std::lock_guard lock(mutex_);
      checking_.erase({lease.rig, lease.epoch});
    }
    if (verdict.put_off) {
      log_("rig " + lease.rig + " cannot be checked now: " + verdict.text);
    } else if (!verdict.passed) {
      log_("rig " + lease.rig + " fails its check: " + verdict.text);
    }
  }
}

/// Stores the result of a check, however long the database is away: what an operator has asked for
/// beside the check would not be done again. If a newer check of the rig has begun, this result is
/// stale and refused, as it should be.
void RigUpkeep::TellVerdict(const lab::Lease& lease, const lab::RigVerdict& verdict) {
  for (;;) {
    const core::Status told =
        service_->Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
          if (verdict.put_off) {
            return scheduler.CheckPutOff(lease.rig, lease.epoch, verdict.text, now);
          }
          return scheduler.CleaningDone(lease.rig, lease.epoch, verdict.passed, verdict.text, now);
        });
    if (told.ok() || told.error().code == core::ErrorCode::kStale) return;
    log_("rig " + lease.rig + ": its check is not stored yet: " + told.error().message);
    if (!IsNotStored(told.error()) || WaitForStop(follow_)) return;
  }
}

/// Waits until nobody holds the rig. An exception of its driver is a failed check.
/// @param kind  of the check, for the log
lab::RigVerdict RigUpkeep::Check(const lab::Lease& lease, std::string& kind) {
  kind = KindOf({});
  try {
    // After a start, a far rig is heard within a second or two.
    while (!rig_pool_.Find(lease.rig).ok() && clock_.Monotonic() < heard_from_) {
      if (WaitForStop(follow_)) break;
    }
    auto hold = rig_pool_.Acquire(lease, kRigPatience);
    if (!hold.ok()) return NotBegun(hold.error());
    const std::set<CheckExtra> extras = TakeExtras(lease.rig);
    kind = KindOf(extras);
    return CheckHeld(hold.value(), extras);
  } catch (const std::exception& error) {
    return {false, error.what(), std::nullopt};
  }
}

/// The check by the rig's own band. When an operator commissions the rig, the check determines the
/// band.
lab::RigVerdict RigUpkeep::CheckHeld(RigHandle& hold, const std::set<CheckExtra>& extras) {
  const std::string& id = hold.lease().rig;
  if (extras.contains(CheckExtra::kClearTrip)) {
    hardware::RigCommand clear;
    clear.kind = hardware::RigCommand::Kind::kClearTrip;
    const core::Status cleared = hold.rig().Command(hold.epoch(), clear);
    if (!cleared.ok()) return lab::VerdictOf(cleared.error());
  }
  const auto band = bands_.Get(id);
  if (!band.ok()) return NotBegun(band.error());
  lab::RigVerdict verdict = lab::CheckRig(hold.rig(), hold.epoch(), band.value());
  if (verdict.passed && extras.contains(CheckExtra::kContacts)) {
    lab::RigVerdict contacts = CheckContactsOf(hold);
    verdict.steps.insert(verdict.steps.end(), contacts.steps.begin(), contacts.steps.end());
    if (!contacts.passed) {
      contacts.steps = std::move(verdict.steps);
      return contacts;
    }
  }
  if (!extras.contains(CheckExtra::kCommission) || !verdict.measured) return verdict;
  const hardware::RigDescription& about = hold.rig().description();
  const core::Result<lab::RigNorm> norm = lab::NominalNorm(*about.bench, about.delta_s);
  core::Status stored =
      norm ? lab::CheckBand(*verdict.measured, norm.value()) : core::Status(norm.error());
  if (stored.ok()) {
    stored = bands_.Put(id, *verdict.measured, "commissioned", clock_.Wall());
    while (!stored.ok() && MayPass(stored.error()) && !WaitForStop(follow_)) {
      stored = bands_.Put(id, *verdict.measured, "commissioned", clock_.Wall());
    }
  }
  if (stored.ok()) return {.passed = true, .measured = verdict.measured, .steps = verdict.steps};
  verdict.passed = false;
  verdict.text = stored.error().message;
  verdict.steps.push_back({.step = "norm", .text = verdict.text});
  return verdict;
}

std::set<CheckExtra> RigUpkeep::TakeExtras(const std::string& rig) {
  const std::lock_guard lock(mutex_);
  const auto found = extras_.find(rig);
  if (found == extras_.end()) return {};
  const std::set<CheckExtra> extras = std::move(found->second);
  extras_.erase(found);
  return extras;
}

void RigUpkeep::LogCheck(const std::string& rig,
                         const std::string& kind,
                         const lab::RigVerdict& verdict) {
  const lab::CheckRecord record{.rig = rig,
                                .at = clock_.Wall(),
                                .kind = kind,
                                .passed = verdict.passed,
                                .reason = verdict.passed ? "" : verdict.text,
                                .steps = verdict.steps};
  core::Status stored = check_log_.Add(record);
  while (!stored.ok() && MayPass(stored.error()) && !WaitForStop(follow_)) {
    stored = check_log_.Add(record);
  }
  if (!stored.ok())
    log_("rig " + rig + ": its check is not in the list: " + stored.error().message);
}

/// Of a rig with relays alone; the parts of a simulator have no wires.
lab::RigVerdict RigUpkeep::CheckContactsOf(RigHandle& hold) {
  if (hold.rig().description().any_value) return {true, "", std::nullopt};
  const auto report = hardware::CheckContacts(hold.rig(), hold.epoch());
  if (!report.ok()) return lab::VerdictOf(report.error());
  const hardware::ContactReport& contacts = report.value();
  {
    const std::lock_guard lock(mutex_);
    contacts_.insert_or_assign(hold.lease().rig, RigContacts{clock_.Wall(), contacts});
  }
  return lab::VerdictOf(contacts);
}

}  // namespace faultlab::server
