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
/// Of a practice lease, beyond twice its run: a busy machine may play it slower than planned.
constexpr milliseconds kPracticeMargin = std::chrono::minutes(10);

/// Rigs that stand somewhere and serve one person at a time. Simulators are elastic: everybody
/// makes runs on them as long as one is free.
bool NeedsSession(const RigStatus& rig) {
  return rig.description.kind == hardware::RigKind::kBench ||
         rig.description.kind == hardware::RigKind::kRemote;
}

/// Why nobody can use this rig now though it is a rig of ours; empty: it can be used.
std::string WhyOffline(const RigStatus& rig) {
  if (rig.remote && !rig.remote->refusal.empty()) return rig.remote->refusal;
  return rig.state == hardware::RigState::kOffline ? "the rig does not answer" : "";
}

}  // namespace

/// What the scheduler asks of this server's rigs.
class LabSystem::Duties : public lab::RigDuties {
 public:
  explicit Duties(LabSystem& system) : system_(system) {}
  void Fence(const lab::RigId& rig, std::uint64_t epoch) override {
    system_.api_.bay.Fence(rig, epoch);
  }
  void StartCleaning(const lab::Lease& lease) override {
    {
      const std::lock_guard lock(system_.mutex_);
      system_.checks_.push_back(lease);
    }
    system_.wake_.notify_all();
  }
  bool RunInProgress(const lab::RigId& rig) override { return system_.api_.bay.Holds(rig); }

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
  lab::LabServiceOptions service_options;
  service_options.member = self.options_.server_id;
  service_options.address = self.options_.address;
  service_options.alone = database.engine() == Engine::kSqlite;
  service_options.clock_error_max = seconds(1);
  service_options.join_patience = service_options.policy.member_lease + seconds(1);
  auto service =
      lab::LabService::Open(database, api.clock, *self.duties_, std::move(service_options));
  if (!service.ok()) return service.error();
  self.service_ = std::move(service).value();
  // From here on this process is the only one of its server_id.
  const auto reaped = self.jobs_.Reap(api.clock.Wall(), self.options_.server_id);
  if (!reaped.ok()) return reaped.error();
  self.lab_api_ = std::make_unique<LabApi>(LabApi{
      accounts, *self.service_, self.jobs_, self.fault_sets_, self.answers_, self.calendar_links_});
  self.feed_ = std::make_unique<LabFeed>(api, *self.lab_api_);
  self.lab_api_->feed = self.feed_.get();
  self.lab_api_->log = self.options_.log;
  self.lab_api_->with_next_check = [&self](const std::string& rig, CheckExtra extra) {
    const std::lock_guard lock(self.mutex_);
    self.extras_[rig].insert(extra);
  };
  api.lab = self.lab_api_.get();
  api.hold_rig = [&self](const Principal& who, const std::string& rig, milliseconds length) {
    return self.HoldRig(who, rig, length);
  };
  api.may_command = [&self](const Principal& who, const std::string& rig) {
    return self.MayCommand(who, rig);
  };
  api.bay.OnRelease([&self](const lab::Lease& lease) { self.GiveBack(lease); });
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
  api_.bay.OnRelease({});
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
  struct Change {
    RigStatus rig;
    bool is_new = false;
  };
  const auto state = service_->state();
  std::vector<Change> changes;
  for (RigStatus& rig : api_.bay.List()) {
    const auto known = state->rigs.find(rig.description.id);
    const bool is_new = known == state->rigs.end();
    const std::string owner = is_new ? "" : known->second.server;
    if (!owner.empty() && owner != service_->member()) continue;  // another member has it
    // An agent that nobody understands has not said what it is.
    if (is_new && rig.description.rig_class.empty()) continue;
    const std::string why = WhyOffline(rig);
    const bool known_offline = is_new || known->second.status == lab::RigStatus::kOffline;
    const bool unclaimed = owner.empty() && why.empty();
    const bool other_reason =
        known_offline && !why.empty() && (is_new || known->second.reason != why);
    if (is_new || unclaimed || !why.empty() != known_offline || other_reason) {
      changes.push_back({std::move(rig), is_new});
    }
  }
  if (changes.empty()) return;
  const core::Status told =
      service_->Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
        for (const auto& [rig, is_new] : changes) {
          const std::string& id = rig.description.id;
          core::Status done = core::Done{};
          if (is_new) done = scheduler.AddRig(id, rig.description.rig_class, !NeedsSession(rig));
          if (done.ok()) {
            const std::string why = WhyOffline(rig);
            done = why.empty() ? scheduler.Claim(id, service_->member(), now)
                               : scheduler.RigOffline(id, why, now);
          }
          if (!done.ok()) options_.log("lab: rig " + id + ": " + done.error().message);
        }
        return core::Done{};
      });
  if (!told.ok()) options_.log("lab: " + told.error().message);
}

/// The active session on this rig that is the caller's.
const lab::Session* LabSystem::SessionOf(const lab::LabState& state,
                                         const Principal& who,
                                         const std::string& rig) {
  for (const auto& [id, session] : state.sessions) {
    if (session.state != lab::SessionState::kActive || session.rig != rig) continue;
    if (session.user != lab::UserId{who.user_id}) continue;
    // The session of a job is for its run alone; only the runner comes without a proof.
    const bool runner = who.proof == Proof::kNone;
    if (session.kind == (runner ? lab::TicketKind::kJob : lab::TicketKind::kPerson)) {
      return &session;
    }
  }
  return nullptr;
}

bool LabSystem::MayCommand(const Principal& who, const std::string& rig) const {
  const auto found = api_.bay.Find(rig);
  if (rig.empty() || !found.ok() || !NeedsSession(found.value()))
    return true;  // a replay, practice
  return SessionOf(*service_->state(), who, rig) != nullptr;
}

/// The lease by the newest stored state, which the service has fenced the bay with before it
/// answers.
core::Result<lab::Lease> LabSystem::LeaseFor(const Principal& who,
                                             const std::string& rig,
                                             milliseconds length) {
  std::vector<lab::RigId> simulators;
  if (rig.empty()) {
    for (const RigStatus& each : api_.bay.List()) {
      if (!NeedsSession(each)) simulators.push_back(each.description.id);
    }
  } else {
    const auto found = api_.bay.Find(rig);
    if (!found) return found.error();
    if (!NeedsSession(found.value())) simulators.push_back(rig);
  }
  return service_->Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Result<lab::Lease> {
    const lab::LabState& state = scheduler.state();
    if (const lab::Session* own = SessionOf(state, who, rig)) {
      const std::string& server = state.rigs.at(rig).server;
      if (server == service_->member()) return lab::LeaseOf(*own);
      return core::Error{core::ErrorCode::kConflict,
                         "Rig '" + rig + "' is moving to another server of this lab (" + server +
                             "); try again in a few seconds.",
                         "/rig"};
    }
    if (!simulators.empty()) {
      auto session = scheduler.Practice(
          lab::UserId{who.user_id}, simulators, 2 * length + kPracticeMargin, now);
      if (!session) return session.error();
      return lab::LeaseOf(session.value());
    }
    if (rig.empty()) {
      return core::Error{core::ErrorCode::kNotFound, "This server has no simulated rig.", "/rig"};
    }
    if (!state.rigs.contains(rig)) {
      return core::Error{
          core::ErrorCode::kUnavailable,
          "Rig '" + rig + "' has just been found and is not checked yet; try again in a minute.",
          "/rig"};
    }
    return core::Error{core::ErrorCode::kForbidden,
                       "This rig needs a session: ask for a place in its queue or book it.",
                       "/rig"};
  });
}

core::Result<RigHold> LabSystem::HoldRig(const Principal& who,
                                         const std::string& rig,
                                         milliseconds length) {
  const core::Result<lab::Lease> lease = LeaseFor(who, rig, length);
  if (!lease) return lease.error();
  auto hold = api_.bay.Acquire(lease.value());
  if (!hold) GiveBack(lease.value());
  return hold;
}

/// Practice is over when its run has let go of the rig.
void LabSystem::GiveBack(const lab::Lease& lease) {
  const auto state = service_->state();
  const auto session = state->sessions.find(lease.session);
  const bool practice =
      session != state->sessions.end() && session->second.kind == lab::TicketKind::kPractice;
  if (!practice) return;
  const core::Status ended =
      service_->Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
        scheduler.EndPractice(lease.session, now);
        return core::Done{};
      });
  // It ends by its own time then.
  if (!ended.ok()) options_.log("lab: practice on " + lease.rig + ": " + ended.error().message);
}

void LabSystem::CheckLoop() {
  while (true) {
    lab::Lease lease;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopping_ || !checks_.empty(); });
      if (stopping_) return;
      lease = std::move(checks_.front());
      checks_.pop_front();
    }
    const lab::RigVerdict verdict = Check(lease);
    // A newer check of the same rig makes this answer stale, which is as it should be.
    const core::Status told =
        service_->Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
          if (verdict.put_off) {
            return scheduler.CheckPutOff(lease.rig, lease.epoch, verdict.text, now);
          }
          return scheduler.CleaningDone(lease.rig, lease.epoch, verdict.passed, verdict.text, now);
        });
    if (!told.ok() && told.error().code != core::ErrorCode::kStale) {
      options_.log("rig " + lease.rig + ": its check cannot be stored: " + told.error().message);
    }
    if (verdict.put_off) {
      options_.log("rig " + lease.rig + " cannot be checked now: " + verdict.text);
    } else if (!verdict.passed) {
      options_.log("rig " + lease.rig + " fails its check: " + verdict.text);
    }
  }
}

/// Waits until nobody holds the rig. What its driver throws is a failed check.
lab::RigVerdict LabSystem::Check(const lab::Lease& lease) {
  try {
    auto hold = api_.bay.Acquire(lease, kRigPatience);
    if (!hold.ok()) return {false, hold.error().message, std::nullopt};
    return CheckHeld(hold.value());
  } catch (const std::exception& error) {
    return {false, error.what(), std::nullopt};
  }
}

/// The check by the rig's own band; when an operator commissions the rig, the check makes the band.
lab::RigVerdict LabSystem::CheckHeld(RigHold& hold) {
  const std::string& id = hold.lease().rig;
  std::set<CheckExtra> extras;
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = extras_.find(id); found != extras_.end()) {
      extras = std::move(found->second);
      extras_.erase(found);
    }
  }
  if (extras.contains(CheckExtra::kClearTrip)) {
    hardware::RigCommand clear;
    clear.kind = hardware::RigCommand::Kind::kClearTrip;
    const core::Status cleared = hold.rig().Command(hold.epoch(), clear);
    if (!cleared.ok()) return lab::VerdictOf(cleared.error());
  }
  const auto band = bands_.Get(id);
  if (!band.ok()) return {false, band.error().message, std::nullopt};
  lab::RigVerdict verdict = lab::CheckRig(hold.rig(), hold.epoch(), band.value());
  if (!extras.contains(CheckExtra::kCommission) || !verdict.measured) return verdict;
  const double period_s = hardware::RunPlan{}.period_s;
  const lab::RigBand nominal = lab::NominalBand(period_s, hold.rig().description().delta_s);
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
