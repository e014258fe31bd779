#include "server/app/lab_system.h"

#include <algorithm>
#include <boost/json.hpp>
#include <utility>

#include "server/api/handlers.h"
#include "server/lab/rig_check.h"

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kRigPatience = seconds(20);  ///< until the last run has let go of the rig
constexpr milliseconds kFollow = seconds(1);
constexpr milliseconds kJobIdle{500};
constexpr milliseconds kJobLease = seconds(60);
constexpr milliseconds kJobPoll{200};

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
  self.lab_api_ = std::make_unique<LabApi>(
      LabApi{accounts, *self.service_, self.jobs_, self.fault_sets_, self.answers_});
  api.lab = self.lab_api_.get();
  api.may_use_rig = [&self](const Principal& who, std::string_view rig) {
    return self.MayUse(who, rig);
  };
  self.FollowRigs();
  self.threads_.emplace_back([&self] { self.CheckLoop(); });
  self.threads_.emplace_back([&self] {
    while (!self.WaitForStop(kFollow)) self.FollowRigs();
  });
  for (int i = 0; i < self.options_.job_workers; ++i) {
    self.threads_.emplace_back([&self] { self.JobLoop(); });
  }
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
  const auto known = state->rigs.find(std::string(rig));
  if (known == state->rigs.end()) return core::Done{};
  for (const auto& [id, session] : state->sessions) {
    const bool active = session.state == lab::SessionState::kActive;
    if (active && session.rig == rig && session.user == lab::UserId{who.user_id}) {
      return core::Done{};
    }
  }
  // A server for one person on a laptop: the guest may use a far rig that nobody else holds.
  const bool alone = who.role == Role::kGuest && known->second.status == lab::RigStatus::kReady &&
                     state->tickets.empty() && state->bookings.empty();
  if (alone) return core::Done{};
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
    const auto give_up = std::chrono::steady_clock::now() + kRigPatience;
    auto lease = api_.bay.Acquire(check.rig);
    while (!lease.ok() && lease.error().code == core::ErrorCode::kBusy &&
           std::chrono::steady_clock::now() < give_up && !WaitForStop(milliseconds(50))) {
      lease = api_.bay.Acquire(check.rig);
    }
    lab::RigVerdict verdict{false, lease.ok() ? "" : lease.error().message};
    if (lease.ok()) {
      RigLease held = std::move(lease).value();
      verdict = lab::CheckRig(held.rig(), held.epoch());
    }
    if (!verdict.passed) options_.log("rig " + check.rig + " fails its check: " + verdict.text);
    // A newer check of the same rig makes this answer stale, which is as it should be.
    (void)service_->CleaningDone(check.rig, check.epoch, verdict.passed, verdict.text);
  }
}

void LabSystem::JobLoop() {
  while (true) {
    const WallTime now = api_.clock.Wall();
    (void)jobs_.Reap(now, "");
    auto job = jobs_.Claim(options_.server_id, now, now + kJobLease);
    if (!job.ok()) options_.log("jobs: " + job.error().message);
    if (job.ok() && job.value()) {
      DoJob(*job.value());
      if (WaitForStop(milliseconds(0))) return;
    } else if (WaitForStop(kJobIdle)) {
      return;
    }
  }
}

void LabSystem::DoJob(const lab::Job& job) {
  const auto account = accounts_.Get(job.account_id);
  if (!account.ok() || account.value().disabled) {
    (void)jobs_.Finish(job.id, "failed", "its account is gone or disabled", api_.clock.Wall());
    return;
  }
  Principal who;
  who.user_id = account.value().id;
  who.login = account.value().login;
  who.name = account.value().name;
  who.role = account.value().role;
  HttpRequest http;
  http.method = HttpMethod::kPost;
  http.path = "/api/v1/runs";
  http.target = http.path;
  http.body = job.body;
  const auto answer = CreateRun(api_, {http, who});
  if (!answer.ok() && answer.error().code == core::ErrorCode::kBusy) {
    (void)jobs_.GiveBack(job.id);
    (void)WaitForStop(kJobIdle);
    return;
  }
  if (!answer.ok()) {
    (void)jobs_.Finish(job.id, "failed", answer.error().message, api_.clock.Wall());
    return;
  }
  const auto created = boost::json::parse(answer.value().body);
  const std::string run(created.as_object().at("id").as_string());
  (void)jobs_.SetRun(job.id, run);
  for (auto live = api_.runs.Find(run); live && live->state == RunState::kRunning;
       live = api_.runs.Find(run)) {
    // Stopping the server stops the run; its job waits for the next start.
    if (WaitForStop(kJobPoll)) return;
    (void)jobs_.Renew(job.id, options_.server_id, api_.clock.Wall() + kJobLease);
  }
  api_.runs.Wait(run);
  const auto record = api_.store.Get(run);
  const bool finished = record.ok() && record.value().state == RunState::kFinished;
  const std::string state(record.ok() ? Name(record.value().state) : "lost");
  (void)jobs_.Finish(job.id,
                     finished ? "finished" : "failed",
                     finished ? "" : "its run ended as " + state,
                     api_.clock.Wall());
}

}  // namespace faultlab::server
