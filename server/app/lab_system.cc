#include "server/app/lab_system.h"

#include <algorithm>
#include <utility>

#include "server/lab/rig_check.h"

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kRigPatience = seconds(20);  ///< until the last run has let go of the rig
constexpr milliseconds kFollow = seconds(1);

/// Rigs that stand somewhere and serve one person at a time. Simulators are elastic: everybody
/// makes runs on them as long as one is free.
bool NeedsSession(const RigStatus& rig) {
  return rig.description.kind == hardware::RigKind::kBench ||
         rig.description.kind == hardware::RigKind::kRemote;
}

}  // namespace

/// What the scheduler asks of this server's rigs.
class LabSystem::Duties : public lab::RigDuties {
 public:
  explicit Duties(LabSystem& system) : system_(system) {}
  void Revoke(const lab::RigId& rig, std::uint64_t) override {
    for (const RunSnapshot& run : system_.api_.runs.Running()) {
      if (run.rig == rig) (void)system_.api_.runs.Stop(run.id, "the session has ended");
    }
  }
  void StartCleaning(const lab::RigId& rig, std::uint64_t epoch) override {
    {
      const std::lock_guard lock(system_.mutex_);
      system_.checks_.push_back({rig, epoch});
    }
    system_.wake_.notify_all();
  }
  bool RunInProgress(const lab::RigId& rig) override {
    const auto running = system_.api_.runs.Running();
    return std::any_of(
        running.begin(), running.end(), [&](const RunSnapshot& run) { return run.rig == rig; });
  }

 private:
  LabSystem& system_;
};

LabSystem::LabSystem(Database& database, Accounts& accounts, ApiContext& api, Options options)
    : api_(api),
      options_(std::move(options)),
      jobs_(database),
      fault_sets_(database),
      answers_(database),
      calendar_links_(database),
      bands_(database),
      database_(database),
      accounts_(accounts),
      duties_(std::make_unique<Duties>(*this)) {}

core::Result<std::unique_ptr<LabSystem>> LabSystem::Open(Database& database,
                                                         Accounts& accounts,
                                                         ApiContext& api,
                                                         Options options) {
  auto system =
      std::unique_ptr<LabSystem>(new LabSystem(database, accounts, api, std::move(options)));
  LabSystem& self = *system;
  const auto reaped = self.jobs_.Reap(api.clock.Wall(), self.options_.server_id);
  if (!reaped.ok()) return reaped.error();
  lab::LabServiceOptions service_options;
  for (const RigStatus& rig : api.bay.List()) {
    if (NeedsSession(rig)) service_options.own_rigs.insert(rig.description.id);
  }
  auto service =
      lab::LabService::Open(database, api.clock, *self.duties_, std::move(service_options));
  if (!service.ok()) return service.error();
  self.service_ = std::move(service).value();
  self.lab_api_ = std::make_unique<LabApi>(LabApi{
      accounts, *self.service_, self.jobs_, self.fault_sets_, self.answers_, self.calendar_links_});
  self.feed_ = std::make_unique<LabFeed>(api, *self.lab_api_);
  self.lab_api_->feed = self.feed_.get();
  self.lab_api_->commission = [&self](const std::string& rig) {
    const std::lock_guard lock(self.mutex_);
    self.commissioned_.insert(rig);
  };
  api.lab = self.lab_api_.get();
  api.may_use_rig = [&self](const Principal& who, std::string_view rig) {
    return self.MayUse(who, rig);
  };
  self.FollowRigs();
  self.threads_.emplace_back([&self] { self.CheckLoop(); });
  self.threads_.emplace_back([&self] {
    do {
      self.FollowRigs();
      self.RetainDaily();
    } while (!self.WaitForStop(kFollow));
  });
  self.jobs_runner_ = std::make_unique<JobRunner>(
      api,
      *self.lab_api_,
      JobRunner::Options{self.options_.server_id, self.options_.job_workers, self.options_.log});
  return system;
}

LabSystem::~LabSystem() {
  Stop();
}

void LabSystem::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (jobs_runner_) jobs_runner_->Stop();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

bool LabSystem::WaitForStop(milliseconds patience) {
  std::unique_lock lock(mutex_);
  return wake_.wait_for(lock, patience, [&] { return stopping_; });
}

/// Rigs come and go: the scheduler learns it here, and cleans what has come.
void LabSystem::FollowRigs() {
  const auto state = service_->state();
  for (const RigStatus& rig : api_.bay.List()) {
    if (!NeedsSession(rig)) continue;
    const std::string& id = rig.description.id;
    const bool offline = rig.state == hardware::RigState::kOffline;
    const auto known = state->rigs.find(id);
    const bool known_offline =
        known == state->rigs.end() || known->second.status == lab::RigStatus::kOffline;
    if (known != state->rigs.end() && offline == known_offline) continue;
    service_->Own(id);
    const core::Status told =
        service_->Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
          if (known == state->rigs.end()) {
            const core::Status added = scheduler.AddRig(id, rig.description.rig_class, false);
            if (!added.ok()) return added;
          }
          return offline ? scheduler.RigOffline(id, "the rig does not answer", now)
                         : scheduler.RigOnline(id, now);
        });
    if (!told.ok()) options_.log("lab: " + told.error().message);
  }
}

core::Status LabSystem::MayUse(const Principal& who, std::string_view rig) const {
  const auto state = service_->state();
  if (!state->rigs.contains(std::string(rig))) {
    // A simulator is for everybody; a bench that the scheduler does not know yet is for nobody.
    const auto found = api_.bay.Find(rig);
    if (!found) return found.error();
    if (!NeedsSession(found.value())) return core::Done{};
    return core::Error{core::ErrorCode::kUnavailable,
                       "Rig '" + std::string(rig) +
                           "' has just been found and is not checked yet; try again in a minute.",
                       "/rig"};
  }
  for (const auto& [id, session] : state->sessions) {
    if (session.state != lab::SessionState::kActive || session.rig != rig) continue;
    if (session.user != lab::UserId{who.user_id}) continue;
    // The session of a job is for its run alone; only the runner comes without a proof.
    const bool runner = who.proof == Proof::kNone;
    if (runner == (session.kind == lab::TicketKind::kJob)) return core::Done{};
  }
  return core::Error{core::ErrorCode::kForbidden,
                     "This rig needs a session: ask for a place in its queue or book it.",
                     "/rig"};
}

void LabSystem::CheckLoop() {
  while (true) {
    Check check;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopping_ || !checks_.empty(); });
      if (stopping_) return;
      check = checks_.front();
      checks_.pop_front();
    }
    const lab::RigVerdict verdict = CheckFree(check.rig);
    if (!verdict.passed) options_.log("rig " + check.rig + " fails its check: " + verdict.text);
    // A newer check of the same rig makes this answer stale, which is as it should be.
    (void)service_->CleaningDone(check.rig, check.epoch, verdict.passed, verdict.text);
  }
}

/// Waits until nobody holds the rig. What its driver throws is a failed check.
lab::RigVerdict LabSystem::CheckFree(const lab::RigId& id) {
  try {
    const auto give_up = std::chrono::steady_clock::now() + kRigPatience;
    auto lease = api_.bay.Acquire(id);
    while (!lease.ok() && lease.error().code == core::ErrorCode::kBusy &&
           std::chrono::steady_clock::now() < give_up && !WaitForStop(milliseconds(50))) {
      lease = api_.bay.Acquire(id);
    }
    if (!lease.ok()) return {false, lease.error().message, std::nullopt};
    RigLease held = std::move(lease).value();
    return CheckHeld(id, held);
  } catch (const std::exception& error) {
    return {false, error.what(), std::nullopt};
  }
}

/// The check by the rig's own band; when an operator commissions the rig, the check makes the band.
lab::RigVerdict LabSystem::CheckHeld(const lab::RigId& id, RigLease& held) {
  bool commission = false;
  {
    const std::lock_guard lock(mutex_);
    commission = commissioned_.erase(id) > 0;
  }
  const auto band = bands_.Get(id);
  if (!band.ok()) return {false, band.error().message, std::nullopt};
  lab::RigVerdict verdict = lab::CheckRig(held.rig(), held.epoch(), band.value());
  if (!commission || !verdict.measured) return verdict;
  const double period_s = hardware::RunPlan{}.period_s;
  const lab::RigBand nominal = lab::NominalBand(period_s, held.rig().description().delta_s);
  core::Status stored = lab::CheckBand(*verdict.measured, nominal);
  if (stored.ok()) {
    stored = bands_.Put(id, *verdict.measured, "commissioned", api_.clock.Wall());
  }
  return {stored.ok(), stored.ok() ? "" : stored.error().message, verdict.measured};
}

/// A day's leftovers go once a day, by the rules of the settings.
void LabSystem::RetainDaily() {
  const WallTime now = api_.clock.Wall();
  if (now < next_retention_) return;
  next_retention_ = now + std::chrono::hours(24);
  const auto kept = lab::Retain(database_, options_.retention, now, /*remove=*/true);
  if (!kept.ok()) {
    options_.log("retention: " + kept.error().message);
  } else if (!kept.value().items.empty()) {
    options_.log("retention: " + std::to_string(kept.value().items.size()) +
                 " recordings and jobs were kept long enough and are gone");
  }
}

}  // namespace faultlab::server
