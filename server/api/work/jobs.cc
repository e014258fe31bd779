// jobs: runs without a person.
#include <algorithm>
#include <boost/json.hpp>
#include <charconv>
#include <set>
#include <variant>

#include "server/api/api.h"
#include "server/experiment/plan_json.h"
#include "server/json/json_reader.h"
#include "server/storage/ids.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kBatchMax = 10'000;
/// Of a larger batch the answer contains the first ones.
constexpr std::size_t kAnsweredMax = 500;

/// Done seconds of the run over its whole length; 0 while it is not known. Of a run here, or of
/// what another server has stored of one.
template <typename Run>
double ProgressOf(const Run& run) {
  const double whole_s = SecondsOfPlan(run.plan_json);
  const double done_s = static_cast<double>(run.samples) * run.period_s;
  return whole_s > 0.0 ? std::min(1.0, done_s / whole_s) : 0.0;
}

/// A diagnosis, or what the methods have said so far.
void AddResult(json::object result, const Job& job, json::object& out) {
  const json::value* of = result.if_contains("of");
  if (of == nullptr) {
    out["diagnosis"] = std::move(result);
    return;
  }
  if (!job.ended_at) {
    const auto done = static_cast<double>(result.at("methods").as_array().size());
    out["progress"] = done / of->to_number<double>();
  }
  out["methods"] = std::move(result);
}

json::object JobToJson(Api& api, const Job& job) {
  json::object out{{"id", job.id},
                   {"batch", job.batch},
                   {"name", job.name},
                   {"run_name", TextOrNull(job.run_name)},
                   {"rig", TextOrNull(job.rig)},
                   {"state", job.state},
                   {"run", TextOrNull(job.run_id)},
                   {"recording", TextOrNull(job.recording)},
                   {"diagnosis", nullptr},
                   {"methods", nullptr},
                   {"error", TextOrNull(job.error)},
                   {"progress", job.state == "finished" ? 1.0 : 0.0},
                   {"attempts", job.attempts},
                   {"created_at", Iso8601(job.created_at)},
                   {"started_at", TimeOrNull(job.started_at)},
                   {"ended_at", TimeOrNull(job.ended_at)}};
  if (!job.result.empty()) AddResult(json::parse(job.result).as_object(), job, out);
  if (job.state == "running" && !job.run_id.empty()) {
    if (const auto live = api.runs.Find(job.run_id)) {
      out["progress"] = ProgressOf(*live);
    } else if (const auto stored = api.store.Get(job.run_id); stored.ok()) {
      out["progress"] = ProgressOf(stored.value());
    }
  }
  return out;
}

/// Refuses now what would be refused when the job's turn comes. The body to keep, a fault set
/// replaced by its faults, and what lists show of it. Adds to `sets` the fault set that it takes.
core::Result<Job> CheckedJob(Api& api,
                             const Principal& who,
                             const json::value& wanted,
                             std::set<std::int64_t>& sets) {
  if (!wanted.is_object()) {
    return core::Error{core::ErrorCode::kInvalid,
                       "A run is a JSON object.",
                       "",
                       "kind_wrong",
                       {{"member", "runs"}}};
  }
  TRY(auto work, api.experiments.ReadWork(wanted.as_object()));
  Job job;
  if (!std::holds_alternative<ExperimentPlan>(work)) {
    const auto* diagnosis = std::get_if<DiagnosisRequest>(&work);
    const auto* methods = std::get_if<MethodsRequest>(&work);
    TRY_DONE(diagnosis != nullptr ? CheckDiagnosis(api.recordings, who, *diagnosis)
                                  : CheckMethods(api.recordings, who, *methods));
    job.recording = diagnosis != nullptr ? diagnosis->recording : methods->recording;
    const json::value* name = wanted.as_object().if_contains("name");
    if (name != nullptr && name->is_string()) job.run_name = name->as_string();
    job.body = json::serialize(wanted);
    return job;
  }
  auto& plan = std::get<ExperimentPlan>(work);
  if (plan.fault_set != 0) sets.insert(plan.fault_set);
  TRY_DONE(api.experiments.Check(who, plan));
  json::object kept = wanted.as_object();
  if (kept.erase("fault_set") > 0) kept["faults"] = ToJson(plan.faults);
  if (plan.hidden_faults) kept["hidden_faults"] = true;
  // By name: the job runs on what the name stands for when its turn comes, or is refused.
  if (plan.recording.empty()) kept["bench"] = plan.bench->name;
  job.run_name = plan.name;
  job.rig = plan.rig;
  job.body = json::serialize(kept);
  return job;
}

core::Result<Job> OwnJob(Api& api, const ApiRequest& request) {
  TRY(auto job, api.jobs.Get(request.http.PathParameter("id")));
  TRY_DONE(Authorize(request.who, Operation::kSubmitJob, OwnershipOf(request.who, job.owner)));
  return job;
}

core::Result<HttpResponse> CreateJobs(Api& api, const ApiRequest& request) {
  ObjectReader in(request.body, "");
  const std::string name = in.TextOr("name", "", 200);
  const json::array* runs = in.ArrayOrNull("runs", kBatchMax);
  if (auto error = in.Finish()) return *error;
  if (runs == nullptr || runs->empty()) {
    return core::Refuse("runs_outside", "/runs");
  }
  const std::string batch = NewId("batch");
  const WallTime now = api.clock.Wall();
  std::vector<Job> jobs;
  std::set<std::int64_t> sets;
  for (std::size_t i = 0; i < runs->size(); ++i) {
    auto checked = CheckedJob(api, request.who, (*runs)[i], sets);
    if (!checked) {
      core::Error error = checked.error();
      error.field = "/runs/" + std::to_string(i) + error.field;
      return error;
    }
    Job job = std::move(checked).value();
    job.id = NewId("job");
    job.owner = request.who.owner_key();
    job.account_id = request.who.user_id;
    job.batch = batch;
    job.name = name;
    job.created_at = now + std::chrono::milliseconds(i);  // keeps the order of the batch
    jobs.push_back(std::move(job));
  }
  for (const std::int64_t set : sets) {
    TRY_DONE(api.fault_sets.MarkUsed(set));
  }
  TRY_DONE(api.jobs.Add(jobs));
  const auto to_json = [&](const Job& job) { return JobToJson(api, job); };
  const auto answered = std::span(jobs).first(std::min(jobs.size(), kAnsweredMax));
  return JsonResponse(
      json::object{{"batch", batch}, {"count", jobs.size()}, {"items", ListOf(answered, to_json)}},
      202);
}

core::Result<HttpResponse> ListJobs(Api& api, const ApiRequest& request) {
  TRY(auto limit, PageLimit(request.http));
  const std::string cursor = request.http.Query("cursor").value_or("");
  std::int64_t before_ms = 0;
  std::string before_id;
  if (!cursor.empty()) {
    const auto [end, error] =
        std::from_chars(cursor.data(), cursor.data() + cursor.size(), before_ms);
    const std::size_t used = static_cast<std::size_t>(end - cursor.data());
    if (error != std::errc() || used + 1 >= cursor.size() || cursor[used] != '.') {
      return core::Refuse("cursor_foreign", "cursor");
    }
    before_id = cursor.substr(used + 1);
  }
  const bool all = Authorize(request.who, Operation::kSubmitJob, Ownership::kForeign).ok();
  TRY(auto jobs,
      api.jobs.List(all ? "" : request.who.owner_key(),
                    request.http.Query("batch").value_or(""),
                    before_ms,
                    before_id,
                    limit));
  std::string next;
  if (jobs.size() == static_cast<std::size_t>(limit)) {
    const Job& last = jobs.back();
    next = std::to_string(ToMilliseconds(last.created_at)) + "." + last.id;
  }
  const auto to_json = [&](const Job& job) { return JobToJson(api, job); };
  return ListAnswer(ListOf(jobs, to_json), next);
}

core::Result<HttpResponse> GetJob(Api& api, const ApiRequest& request) {
  TRY(auto job, OwnJob(api, request));
  return JsonUntilSettled(JobToJson(api, job), job.ended_at.has_value());
}

/// What is left of jobs that have just been cancelled. A run that is about to begin, or that
/// another server has, is stopped by who runs the job.
core::Status StopWhatRuns(Api& api, std::span<const Job> cancelled) {
  std::set<std::string> ids;
  for (const Job& job : cancelled) {
    if (!job.run_id.empty()) (void)api.runs.Stop(job.run_id, "its job was cancelled");
    ids.insert(job.id);
  }
  // Their places in the queue of a bench, or the rig that one was just given: a few at a time.
  return api.service.Do([&](lab::Scheduler& scheduler, WallTime now) -> core::Status {
    std::set<std::string> at_benches;
    for (const auto& [id, ticket] : scheduler.state().tickets) at_benches.insert(ticket.job);
    for (const auto& [id, session] : scheduler.state().sessions) at_benches.insert(session.job);
    for (const std::string& job : at_benches) {
      if (!ids.contains(job)) continue;
      TRY_DONE(scheduler.DropJob(job, now));
    }
    return core::Done{};
  });
}

core::Result<HttpResponse> CancelJob(Api& api, const ApiRequest& request) {
  TRY(auto job, OwnJob(api, request));
  TRY(const auto cancelled, api.jobs.Cancel(job.id, api.clock.Wall()));
  TRY_DONE(StopWhatRuns(api, {&cancelled, 1}));
  return NoContent();
}

core::Result<JobStore::Batch> OwnBatch(Api& api, const ApiRequest& request) {
  TRY(auto batch, api.jobs.BatchOf(request.http.PathParameter("id")));
  TRY_DONE(Authorize(request.who, Operation::kSubmitJob, OwnershipOf(request.who, batch.owner)));
  return batch;
}

core::Result<HttpResponse> GetBatch(Api& api, const ApiRequest& request) {
  TRY(const auto batch, OwnBatch(api, request));
  json::object out{{"batch", request.http.PathParameter("id")},
                   {"name", batch.name},
                   {"created_at", Iso8601(batch.created_at)},
                   {"ended_at", TimeOrNull(batch.ended_at)}};
  std::int64_t count = 0;
  for (const char* state : {"waiting", "running", "finished", "failed", "cancelled"}) {
    const auto found = batch.count.find(state);
    const std::int64_t of = found == batch.count.end() ? 0 : found->second;
    out[state] = of;
    count += of;
  }
  out["count"] = count;
  return JsonUntilSettled(out, batch.ended_at.has_value());
}

core::Result<HttpResponse> CancelBatch(Api& api, const ApiRequest& request) {
  TRY_DONE(OwnBatch(api, request));
  TRY(const auto cancelled,
      api.jobs.CancelBatch(request.http.PathParameter("id"), api.clock.Wall()));
  if (cancelled.empty()) return core::Refuse("job_ended");
  TRY_DONE(StopWhatRuns(api, cancelled));
  return NoContent();
}

}  // namespace

std::span<const ApiRoute> JobsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "jobs", kSubmitJob, kRole, ListJobs}.Takes("cursor limit batch"),
      {kPost, "jobs", kSubmitJob, kRole, CreateJobs, kJobBatch, kQuick, kBodysRig},
      ApiRoute{kGet, "jobs/{id}", kSubmitJob, kRole, GetJob}.Takes("wait"),
      {kDelete, "jobs/{id}", kSubmitJob, kRole, CancelJob},
      ApiRoute{kGet, "jobs/batches/{id}", kSubmitJob, kRole, GetBatch}.Takes("wait"),
      {kDelete, "jobs/batches/{id}", kSubmitJob, kRole, CancelBatch},
  });
  return kRoutes;
}

}  // namespace faultlab::server
