#include "server/app/job_runner.h"

#include <utility>
#include <variant>

namespace faultlab::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kIdle{500};
constexpr milliseconds kLease = seconds(60);
constexpr milliseconds kPoll{200};
/// A job that found no rig is tried again after this time; other jobs have their turn meanwhile.
constexpr milliseconds kNextLook = seconds(1);
/// The server that has the job's rig has this long to claim the job; after that any server may.
constexpr milliseconds kHandedFor = seconds(10);
/// Time for arming, the first sample and the end of the recording, in addition to the run itself.
constexpr milliseconds kMargin = seconds(30);

}  // namespace

JobRunner::JobRunner(Parts parts, Options options) : parts_(parts), options_(std::move(options)) {
  for (int i = 0; i < options_.workers; ++i) {
    threads_.emplace_back([this] { Loop(); });
  }
}

JobRunner::~JobRunner() {
  Stop();
}

void JobRunner::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
}

bool JobRunner::WaitForStop(milliseconds patience) {
  std::unique_lock lock(mutex_);
  return wake_.wait_for(lock, patience, [&] { return stopping_; });
}

void JobRunner::Loop() {
  while (true) {
    const WallTime now = parts_.clock.Wall();
    Log(parts_.jobs.Reap(now, ""));
    const auto job = parts_.jobs.Claim(options_.server_id, now, now + kLease);
    Log(job);
    if (job.ok() && job.value()) {
      Do(*job.value());
      if (WaitForStop(milliseconds(0))) return;
    } else if (WaitForStop(kIdle)) {
      return;
    }
  }
}

void JobRunner::Finish(const lab::Job& job, const std::string& state, const std::string& error) {
  Log(parts_.jobs.Finish(job, state, error, parts_.clock.Wall()));
}

/// If this fails, the job waits again after its lease has ended.
void JobRunner::GiveBack(const lab::Job& job) {
  Log(parts_.jobs.GiveBack(job, parts_.clock.Wall() + kNextLook));
}

std::optional<Principal> JobRunner::OwnerOf(const lab::Job& job) const {
  const auto account = parts_.accounts.Get(job.account_id);
  if (!account.ok() || account.value().disabled) return std::nullopt;
  Principal who;
  who.user_id = account.value().id;
  who.login = account.value().login;
  who.name = account.value().name;
  who.role = account.value().role;
  return who;
}

void JobRunner::Do(const lab::Job& job) {
  const std::optional<Principal> who = OwnerOf(job);
  if (!who) return Finish(job, "failed", "its account is gone or disabled");
  auto work = parts_.experiments.ReadWork(std::string_view(job.body));
  if (!work) return Finish(job, "failed", work.error().message);
  if (const auto* request = std::get_if<DiagnosisRequest>(&work.value())) {
    DoDiagnosis(job, *who, *request);
  } else {
    DoRun(job, *who, std::get<ExperimentPlan>(std::move(work).value()));
  }
}

void JobRunner::DoDiagnosis(const lab::Job& job,
                            const Principal& who,
                            const DiagnosisRequest& request) {
  const core::Result<std::string> result = Diagnose(parts_.recordings, who, request);
  if (!result.ok()) return Finish(job, "failed", result.error().message);
  const core::Status kept = parts_.jobs.SetResult(job, result.value());
  Finish(job, kept.ok() ? "finished" : "failed", kept.ok() ? "" : kept.error().message);
}

/// Whether the rig needs no session; "" means any such rig.
bool JobRunner::IsElastic(const std::string& rig) const {
  const auto state = parts_.service.state();
  const auto known = state->rigs.find(rig);
  return known == state->rigs.end() || known->second.elastic;
}

core::Result<std::optional<std::string>> JobRunner::RigFor(const lab::Job& job,
                                                           const ExperimentPlan& plan) {
  using MaybeRig = std::optional<std::string>;
  if (IsElastic(plan.rig)) return MaybeRig{plan.rig};
  const auto state = parts_.service.state();
  lab::TicketRequest request;
  request.user = lab::UserId{job.account_id};
  request.rig_class = state->rigs.at(plan.rig).rig_class;
  request.kind = lab::TicketKind::kJob;
  request.job = job.id;
  request.weight = parts_.service.policy().job_weight_s;
  request.min = request.want =
      std::chrono::ceil<milliseconds>(std::chrono::duration<double>(plan.duration_s)) + kMargin;
  const auto answer = parts_.service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.RequestTicket(request, now);
  });
  if (!answer.ok()) {
    if (answer.error().code == core::ErrorCode::kBusy) return MaybeRig{};
    return answer.error();
  }
  const auto* session = std::get_if<lab::Session>(&answer.value());
  if (session == nullptr || session->state != lab::SessionState::kActive) return MaybeRig{};
  if (!parts_.service.MemberOf(session->rig)) return MaybeRig{};
  return MaybeRig{session->rig};
}

void JobRunner::DoRun(const lab::Job& job, const Principal& who, ExperimentPlan plan) {
  const auto rig = RigFor(job, plan);
  if (!rig.ok()) return Finish(job, "failed", rig.error().message);
  if (!rig.value()) return GiveBack(job);
  plan.rig = *rig.value();
  if (const auto member = parts_.service.MemberOf(plan.rig);
      member && member->id != options_.server_id) {
    Log(parts_.jobs.HandTo(job, member->id, parts_.clock.Wall() + kHandedFor));
    return;
  }
  const bool in_session = !IsElastic(plan.rig);
  const auto started = parts_.experiments.Start(who, StartedBy::kJob, std::move(plan));
  if (!started.ok() && started.error().code == core::ErrorCode::kBusy) return GiveBack(job);
  if (started.ok()) {
    Follow(job, started.value().id);
  } else {
    Finish(job, "failed", started.error().message);
  }
  // When the server stops, the session stays with its job.
  if (!in_session || WaitForStop(milliseconds(0))) return;
  Log(parts_.service.Do(
      [&](lab::Scheduler& scheduler, WallTime now) { return scheduler.DropJob(job.id, now); }));
}

void JobRunner::Follow(const lab::Job& job, const std::string& run) {
  Log(parts_.jobs.SetRun(job, run));
  for (auto live = parts_.runs.Find(run); live && live->state == RunState::kRunning;
       live = parts_.runs.Find(run)) {
    // Stopping the server stops the run; its job waits for the next start.
    if (WaitForStop(kPoll)) return;
    const core::Status renewed = parts_.jobs.Renew(job, parts_.clock.Wall() + kLease);
    Log(renewed);
    if (!renewed.ok() && renewed.error().code == core::ErrorCode::kStale) {
      Log(parts_.runs.Stop(run, "its job has gone to another server"));
      return;
    }
  }
  parts_.runs.Wait(run);
  const auto record = parts_.store.Get(run);
  const bool finished = record.ok() && record.value().state == RunState::kFinished;
  const std::string state(record.ok() ? Name(record.value().state) : "lost");
  Finish(job, finished ? "finished" : "failed", finished ? "" : "its run ended as " + state);
}

}  // namespace faultlab::server
