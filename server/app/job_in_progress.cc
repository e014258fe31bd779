// What a job does on its own thread (job_runner.h).
#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "server/app/job_runner.h"

namespace faultlab::server {

std::optional<Principal> JobRunner::OwnerOf(const Job& job) const {
  const auto account = parts_.accounts.Get(job.account_id);
  if (!account.ok() || account.value().disabled) return std::nullopt;
  return PrincipalOf(account.value());
}

void JobRunner::Do(InProgress& it) {
  const std::optional<Principal> who = OwnerOf(it.job);
  auto work = parts_.experiments.ReadWork(std::string_view(it.job.body));
  if (!who) {
    Finish(it.job, "failed", "its account is gone or disabled");
  } else if (!work) {
    Finish(it.job, "failed", work.error().message);
  } else if (const auto* request = std::get_if<DiagnosisRequest>(&work.value())) {
    DoDiagnosis(it.job, *who, *request);
  } else if (const auto* methods = std::get_if<MethodsRequest>(&work.value())) {
    DoMethods(it.job, *who, *methods);
  } else {
    DoRun(it, *who, std::get<ExperimentPlan>(std::move(work).value()));
  }
  // When the server stops, the session stays with its job.
  if (!it.bench.empty() && !stopping() && !IsPutOff(it.job.id)) Drop(it.job.id);
}

void JobRunner::DoDiagnosis(const Job& job, const Principal& who, const DiagnosisRequest& request) {
  const core::Result<std::string> result = Diagnose(parts_.recordings, who, request);
  if (!result.ok() && result.error().reason == LongTurn::kTaken) return AwaitTurn(job);
  if (!result.ok()) return Finish(job, "failed", result.error().message);
  const core::Status kept = parts_.jobs.SetResult(job, result.value());
  Finish(job, kept.ok() ? "finished" : "failed", kept.ok() ? "" : kept.error().message);
}

/// Keeps what each method has said at once: whoever waits sees it come. Cancelled, or claimed by
/// another server meanwhile, the job is not this server's to end.
void JobRunner::DoMethods(const Job& job, const Principal& who, const MethodsRequest& request) {
  const core::Error leaves{
      core::ErrorCode::kBusy, "the job goes on later", "", "job_goes_on_later"};
  const core::Result<std::string> result = CompareMethods(
      parts_.recordings, who, request, job.result, [&](const std::string& so_far, bool is_long) {
        const core::Status kept = parts_.jobs.SetResult(job, so_far);
        if (!kept.ok()) return kept;
        const std::lock_guard lock(mutex_);
        const bool gives_way = is_long && OthersAwaitTurn(job.owner);
        if (gives_way) gave_way_.insert(job.owner);  // before the turn is free
        return stopping_ || gives_way ? core::Status(leaves) : kept;
      });
  if (result.ok()) return Finish(job, "finished", "");
  if (result.error().reason == LongTurn::kTaken) return AwaitTurn(job);
  if (result.error().reason == leaves.reason || stopping()) return Log(parts_.jobs.GiveBack(job));
  if (result.error().code != core::ErrorCode::kStale) Finish(job, "failed", result.error().message);
}

void JobRunner::DoRun(InProgress& it, const Principal& who, ExperimentPlan plan) {
  if (!it.bench.empty()) plan.rig = it.bench;
  const auto started = parts_.experiments.Start(who, StartedBy::kJob, std::move(plan));
  if (started.ok()) return Follow(it, started.value().id);
  if (started.error().reason == LongTurn::kTaken) return AwaitTurn(it.job);
  if (started.error().code != core::ErrorCode::kBusy) {
    return Finish(it.job, "failed", started.error().message);
  }
  PutOff(it.job, Needs::kAnyRig);
  Log(parts_.jobs.GiveBack(it.job));
}

void JobRunner::Follow(InProgress& it, const std::string& run) {
  const core::Status kept = parts_.jobs.SetRun(it.job, run);
  bool stop = !kept.ok();  // cancelled meanwhile, or another server may have the job
  {
    const std::lock_guard lock(mutex_);
    it.run = run;
    it.over = stop;
    stop = stop || stopping_;
  }
  if (stop) (void)parts_.runs.Stop(run, kept.ok() ? kServerStops : "its job is over");
  parts_.runs.Wait(run);
  FinishByRun(it);
}

void JobRunner::FinishByRun(const InProgress& it) {
  const auto record = parts_.store.Get(it.run);
  if (!record.ok()) return FinishLost(it.job, "its run ended as lost");
  const RunState state = record.value().state;
  if (state == RunState::kFinished) return Finish(it.job, "finished", "");
  if (state == RunState::kStopped && stopping()) return Log(parts_.jobs.GiveBack(it.job));
  const auto lab_state = parts_.service.state();
  const bool taken_away = !it.bench.empty() && SessionOf(*lab_state, it.job.id) == nullptr;
  if (state == RunState::kStopped && !taken_away) {
    return Finish(it.job, "cancelled", "its run was stopped");
  }
  FinishLost(it.job, "its run ended as " + std::string(Name(state)));
}

void JobRunner::AwaitTurn(const Job& job) {
  {
    const std::lock_guard lock(mutex_);
    await_turn_[job.id] = job.owner;
  }
  Log(parts_.jobs.GiveBack(job));
}

/// Under the lock.
bool JobRunner::OthersAwaitTurn(const std::string& owner) const {
  return std::ranges::any_of(await_turn_, [&](const auto& each) { return each.second != owner; });
}

void JobRunner::Finish(const Job& job, const std::string& state, const std::string& error) {
  const core::Status stored = parts_.jobs.Finish(job, state, error, parts_.clock.Wall());
  // A claim that is over has been told to the job's owner already.
  if (!stored.ok() && stored.error().code != core::ErrorCode::kStale) Log(stored);
}

/// By no fault of whoever sent it.
void JobRunner::FinishLost(const Job& job, const std::string& error) {
  Finish(job, "failed", error);
  const std::string& where = job.rig.empty() ? parts_.service.member() : job.rig;
  const std::string what = "job " + job.id + ": " + error;
  options_.log(what);
  Log(parts_.alarms.Raise(lab::AlarmKind::kJobFailed, where, what, parts_.clock.Wall()));
}

}  // namespace faultlab::server
