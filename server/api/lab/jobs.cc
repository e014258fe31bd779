// jobs: runs without a person.
#include <boost/json.hpp>
#include <charconv>

#include "server/api/diagnose_job.h"
#include "server/api/json_reader.h"
#include "server/api/lab/handlers.h"
#include "server/api/run_body.h"
#include "server/storage/ids.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kBatchMax = 500;

/// Done seconds of the run over its whole length; 0 while it is not known.
/// Of a run here, or of what another server has stored of one.
template <typename Run>
double ProgressOf(const Run& live) {
  boost::system::error_code ec;
  const json::value plan = json::parse(live.plan_json, ec);
  const json::value* duration = ec ? nullptr : plan.as_object().if_contains("duration_s");
  const double whole_s =
      duration != nullptr && duration->is_number() ? duration->to_number<double>() : 0.0;
  const double done_s = static_cast<double>(live.samples) * live.period_s;
  return whole_s > 0.0 ? std::min(1.0, done_s / whole_s) : 0.0;
}

json::object JobToJson(ApiContext& api, const lab::Job& job) {
  json::object out{{"id", job.id},
                   {"batch", job.batch},
                   {"name", job.name},
                   {"run_name", nullptr},
                   {"rig", nullptr},
                   {"state", job.state},
                   {"run", nullptr},
                   {"recording", nullptr},
                   {"diagnosis", nullptr},
                   {"error", nullptr},
                   {"progress", job.state == "finished" ? 1.0 : 0.0},
                   {"attempts", job.attempts},
                   {"created_at", Iso8601(job.created_at)},
                   {"started_at", nullptr},
                   {"ended_at", nullptr}};
  // The body was checked when the job came.
  const json::object body = json::parse(job.body).as_object();
  if (const json::value* name = body.if_contains("name")) out["run_name"] = *name;
  if (const json::value* rig = body.if_contains("rig")) out["rig"] = *rig;
  if (const json::value* diagnose = body.if_contains("diagnose")) {
    out["recording"] = diagnose->at("recording");
  }
  if (!job.result.empty()) out["diagnosis"] = json::parse(job.result);
  if (!job.run_id.empty()) out["run"] = job.run_id;
  if (!job.error.empty()) out["error"] = job.error;
  if (job.started_at) out["started_at"] = Iso8601(*job.started_at);
  if (job.ended_at) out["ended_at"] = Iso8601(*job.ended_at);
  if (job.state == "running" && !job.run_id.empty()) {
    if (const auto live = api.runs.Find(job.run_id)) {
      out["progress"] = ProgressOf(*live);
    } else if (const auto stored = api.store.Get(job.run_id); stored.ok()) {
      out["progress"] = ProgressOf(stored.value());
    }
  }
  return out;
}

/// Refuses now what would be refused when the job's turn comes; the body with its fault set
/// expanded.
core::Result<std::string> CheckedJobBody(ApiContext& api,
                                         const Principal& who,
                                         const json::value& wanted) {
  if (!wanted.is_object()) {
    return core::Error{core::ErrorCode::kInvalid, "A run is a JSON object.", ""};
  }
  auto diagnose = ParseDiagnoseJob(wanted.as_object());
  if (!diagnose) return diagnose.error();
  if (diagnose.value()) {
    const core::Status readable = CheckDiagnoseJob(api, who, *diagnose.value());
    if (!readable.ok()) return readable.error();
    return json::serialize(wanted);
  }
  auto text = ExpandFaultSet(api, who, json::serialize(wanted));
  if (!text) return text.error();
  auto parsed = ParseRunBody(text.value(), api.default_seed);
  if (!parsed) return parsed.error();
  if (parsed.value().recording.empty()) {
    auto rig = api.bay.Find(parsed.value().rig);
    if (!rig) return rig.error();
    auto plan = ResolvePlan(parsed.value(), rig.value().description);
    if (!plan) return plan.error();
  }
  return text;
}

core::Result<lab::Job> OwnJob(ApiContext& api, const ApiRequest& request) {
  auto job = api.lab->jobs.Get(request.http.PathParameter("id"));
  if (!job) return job.error();
  const core::Status allowed =
      Authorize(request.who, Operation::kSubmitJob, OwnershipOf(request.who, job.value().owner));
  if (!allowed.ok()) return allowed.error();
  return job;
}

}  // namespace

core::Result<HttpResponse> CreateJobs(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto body = ParseJsonObject(request.http.body);
  if (!body) return body.error();
  ObjectReader in(body.value(), "");
  const std::string name = in.TextOr("name", "", 200);
  const json::array* runs = in.ArrayOrNull("runs", kBatchMax);
  if (auto error = in.Finish()) return *error;
  if (runs == nullptr || runs->empty()) {
    return core::Error{core::ErrorCode::kInvalid, "Give 1 to 500 runs.", "/runs"};
  }
  const std::string batch = NewId("batch");
  const WallTime now = api.clock.Wall();
  std::vector<lab::Job> jobs;
  for (std::size_t i = 0; i < runs->size(); ++i) {
    auto text = CheckedJobBody(api, request.who, (*runs)[i]);
    if (!text) {
      core::Error error = text.error();
      error.field = "/runs/" + std::to_string(i) + error.field;
      return error;
    }
    lab::Job job;
    job.id = NewId("job");
    job.owner = request.who.owner_key();
    job.account_id = request.who.user_id;
    job.batch = batch;
    job.name = name;
    job.body = text.value();
    job.created_at = now + std::chrono::milliseconds(i);  // keeps the order of the batch
    jobs.push_back(std::move(job));
  }
  const core::Status added = lab.value()->jobs.Add(jobs);
  if (!added.ok()) return added.error();
  json::array items;
  for (const lab::Job& job : jobs) items.push_back(JobToJson(api, job));
  return JsonResponse(json::object{{"batch", batch}, {"items", std::move(items)}}, 202);
}

core::Result<HttpResponse> ListJobs(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  const core::Status known = OnlyQuery(request.http, {"cursor", "limit", "batch"});
  if (!known.ok()) return known.error();
  auto limit = PageLimit(request.http);
  if (!limit) return limit.error();
  const std::string cursor = request.http.Query("cursor").value_or("");
  std::int64_t before_ms = 0;
  std::string before_id;
  if (!cursor.empty()) {
    const auto [end, error] =
        std::from_chars(cursor.data(), cursor.data() + cursor.size(), before_ms);
    const std::size_t used = static_cast<std::size_t>(end - cursor.data());
    if (error != std::errc() || used + 1 >= cursor.size() || cursor[used] != '.') {
      return core::Error{
          core::ErrorCode::kInvalid, "This cursor does not come from this list.", "cursor"};
    }
    before_id = cursor.substr(used + 1);
  }
  const bool all = Allowed(request.who.role, Operation::kSubmitJob, Ownership::kForeign);
  auto jobs = lab.value()->jobs.List(all ? "" : request.who.owner_key(),
                                     request.http.Query("batch").value_or(""),
                                     before_ms,
                                     before_id,
                                     limit.value());
  if (!jobs) return jobs.error();
  json::array items;
  for (const lab::Job& job : jobs.value()) items.push_back(JobToJson(api, job));
  json::object out{{"items", std::move(items)}, {"next_cursor", nullptr}};
  if (jobs.value().size() == static_cast<std::size_t>(limit.value())) {
    const lab::Job& last = jobs.value().back();
    out["next_cursor"] = std::to_string(ToMilliseconds(last.created_at)) + "." + last.id;
  }
  return JsonResponse(out);
}

core::Result<HttpResponse> GetJob(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto job = OwnJob(api, request);
  if (!job) return job.error();
  return JsonResponse(JobToJson(api, job.value()));
}

core::Result<HttpResponse> CancelJob(ApiContext& api, const ApiRequest& request) {
  auto lab = LabOf(api);
  if (!lab) return lab.error();
  auto job = OwnJob(api, request);
  if (!job) return job.error();
  const core::Status done = lab.value()->jobs.Cancel(job.value().id, api.clock.Wall());
  if (!done.ok()) return done.error();
  // Its place in the queue of a bench, or the rig that it was just given.
  const core::Status left = lab.value()->service.Do([&](lab::Scheduler& scheduler, WallTime now) {
    return scheduler.DropJob(job.value().id, now);
  });
  if (!left.ok()) return left.error();
  return NoContent();
}

}  // namespace faultlab::server
