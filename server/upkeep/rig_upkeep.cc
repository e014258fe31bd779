#include "server/upkeep/rig_upkeep.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "server/experiment/rig_access.h"
#include "server/storage/database_error.h"

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kRigPatience = seconds(20);  ///< until the last run has released the rig
/// A check is three seconds of waiting for the rig: all rigs of a laboratory are ready after those.
constexpr int kChecksAtOnce = 16;
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
  roll_call_.emplace(service, clock_, log_);
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
    if (!checks_.Add(lease)) return;
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

void RigUpkeep::FollowRigs() {
  std::vector<RigStatus> rigs = rig_pool_.List();
  FollowBenches(rigs);
  roll_call_->Take(std::move(rigs));
}

void RigUpkeep::CheckLoop() {
  while (true) {
    lab::Lease lease;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopping_ || !checks_.empty(); });
      if (stopping_) return;
      lease = checks_.Begin();
    }
    std::string kind;
    const lab::RigVerdict verdict = Check(lease, kind);
    // Before the rig is free: who sees that a check has ended finds it in the list.
    if (!verdict.put_off) LogCheck(lease.rig, kind, verdict);
    while (TellVerdict(*service_, lease, verdict, log_) && !WaitForStop(follow_)) {
    }
    {
      const std::lock_guard lock(mutex_);
      checks_.End(lease);
    }
    if (verdict.put_off) {
      log_("rig " + lease.rig + " cannot be checked now: " + verdict.text);
    } else if (!verdict.passed) {
      log_("rig " + lease.rig + " fails its check: " + verdict.text);
    }
  }
}

/// Waits until nobody holds the rig. An exception of its driver is a failed check.
/// @param kind  of the check, for the log
lab::RigVerdict RigUpkeep::Check(const lab::Lease& lease, std::string& kind) {
  kind = KindOf({});
  try {
    // After a start, a far rig is heard within a second or two.
    while (!rig_pool_.Find(lease.rig).ok() && !roll_call_->AllHeard()) {
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
