// jobs/batches/{id}/sweep and curves: what the runs of a batch switched, what was found, and what
// was measured.
#include "server/plots/sweep_figure.h"

#include <algorithm>
#include <boost/json.hpp>

#include "core/types/number_text.h"
#include "server/api/api.h"
#include "server/api/run/file_names.h"
#include "server/api/run/truth.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/experiment/plan_json.h"
#include "server/json/number_or_null.h"
#include "server/plots/render.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr bool kOneBench = true;
constexpr int kRunsMax = 10'000;  ///< of a batch

/// Of the run's first episode.
SweepRun RunOf(const RunRecord& record,
               const core::Diagnosis& diagnosis,
               const core::Bench& bench) {
  SweepRun run;
  const std::vector<core::Fault> faults = FaultsOfPlan(record.plan_json, bench);
  if (!faults.empty()) {
    run.component = faults.front().component;
    run.value = faults.front().value;
  }
  const core::Verdict& verdict =
      diagnosis.episodes.empty() ? diagnosis.verdict : diagnosis.episodes.front().verdict;
  if (verdict.kind == core::VerdictKind::kFault) {
    run.named = core::NamedBy(verdict);
    if (!verdict.candidates.empty() && verdict.candidates.front().bound == 0) {
      run.found = verdict.candidates.front().value;
    }
  }
  run.unknown = verdict.kind == core::VerdictKind::kUnknownFault;
  if (verdict.detected_at_s && !faults.empty()) {
    run.delay_s = *verdict.detected_at_s - faults.front().at_s;
  }
  return run;
}

/// Whoever may read a run may see what was found in it.
bool MayRead(Api& api, const Principal& who, const Job& job) {
  if (Authorize(who, Operation::kSubmitJob, OwnershipOf(who, job.owner)).ok()) return true;
  if (job.run_id.empty()) return false;
  const auto run = api.store.Get(job.run_id);
  if (!run) return false;
  const auto whose = api.accounts.RelationTo(who, run.value().owner, run.value().created_at);
  return whose.ok() && Authorize(who, Operation::kReadRun, whose.value()).ok();
}

/// The runs of a batch that have ended and whose faults may be told, as they were requested.
struct Sweep {
  std::string batch;
  Job first;
  const core::Bench* bench = nullptr;
  std::vector<std::string> ids;
  std::vector<SweepRun> runs;  ///< of the same

  std::string Footer() const {
    const std::string count = std::to_string(runs.size());
    return "faultlab · " + batch + " · " + count + (runs.size() == 1 ? " run" : " runs");
  }
};

/// The jobs of a batch whose runs the caller may see, as they were requested.
core::Result<std::vector<Job>> JobsOf(Api& api, const ApiRequest& request) {
  TRY(auto jobs, api.jobs.List("", request.http.PathParameter("id"), 0, "", kRunsMax));
  std::erase_if(jobs, [&](const Job& job) { return !MayRead(api, request.who, job); });
  if (jobs.empty()) return core::Refuse("nothing_here");
  std::ranges::reverse(jobs);
  return jobs;
}

/// What became of the jobs of a batch that have a run, one after another: a batch may have more
/// than fits into memory.
/// @param one_bench  only those on the bench of the first
/// @param visit  (const Job&, const RunRecord&, const SweepRun&)
core::Result<Sweep> VisitSweep(Api& api,
                               const ApiRequest& request,
                               std::span<const Job> jobs,
                               bool one_bench,
                               const auto& visit) {
  Sweep sweep;
  sweep.batch = request.http.PathParameter("id");
  sweep.first = jobs.front();
  bool any_hidden = false;
  bool any = false;
  for (const Job& job : jobs) {
    if (job.state != "finished" || job.run_id.empty()) continue;
    auto stored = api.store.Get(job.run_id);
    if (!stored) continue;  // deleted since
    TRY(auto record, RunForFile(request.who, request.http, std::move(stored).value()));
    if (IsSealed(record.plan_json)) {
      any_hidden = true;
      continue;
    }
    const auto own = api.benches.OfRecording(record.bench);
    if (!own) continue;
    if (one_bench && sweep.bench != nullptr && own.value() != sweep.bench) continue;
    sweep.bench = own.value();
    const auto diagnosis = ParseDiagnosis(record.diagnosis_json, *own.value());
    if (!diagnosis) continue;
    any = true;
    visit(job, record, RunOf(record, diagnosis.value(), *own.value()));
  }
  if (any) return sweep;
  return any_hidden ? core::Refuse("batch_hidden", "truth") : core::Refuse("no_run_finished");
}

core::Result<Sweep> SweepOf(Api& api, const ApiRequest& request) {
  TRY(const auto jobs, JobsOf(api, request));
  std::vector<std::string> ids;
  std::vector<SweepRun> runs;
  TRY(auto sweep,
      VisitSweep(api,
                 request,
                 jobs,
                 kOneBench,
                 [&](const Job&, const RunRecord& record, const SweepRun& run) {
                   ids.push_back(record.id);
                   runs.push_back(run);
                 }));
  sweep.ids = std::move(ids);
  sweep.runs = std::move(runs);
  return sweep;
}

core::Result<HttpResponse> SweepPng(const Sweep& sweep,
                                    const Figure& figure,
                                    std::int64_t scale,
                                    const std::string& kind) {
  TRY(auto png, RenderPng(figure, {.scale = static_cast<int>(scale)}));
  return Png(std::move(png), FileNameOf(sweep.first.created_at, sweep.first.name, kind, "png"));
}

core::Result<HttpResponse> GetSweepPlot(Api& api, const ApiRequest& request) {
  TRY(const auto scale, QueryInteger(request.http, "scale", 1, 1, 2));
  TRY(const auto sweep, SweepOf(api, request));
  const auto symbols = sweep.bench->components();
  const std::vector<core::Component> components(symbols.begin(), symbols.end());
  const std::string title = sweep.first.name + " · " + sweep.bench->name;
  return SweepPng(
      sweep, MakeSweepFigure(sweep.runs, components, title, sweep.Footer()), scale, "sweep");
}

/// One curve a run.
core::Result<HttpResponse> GetCurvesPlot(Api& api, const ApiRequest& request) {
  TRY(const auto scale, QueryInteger(request.http, "scale", 1, 1, 2));
  TRY(const auto sweep, SweepOf(api, request));
  if (sweep.ids.size() > kSweptMax) {
    return core::Refuse("curves_too_many", "", {{"most", kSweptMax}, {"runs", sweep.runs.size()}});
  }
  std::vector<RunRecord> stored;
  std::vector<SweptRecord> records;
  for (const std::string& id : sweep.ids) {
    TRY(auto record, api.store.Get(id));
    const std::vector<core::Fault> faults = FaultsOfPlan(record.plan_json, *sweep.bench);
    SweptRecord& swept = records.emplace_back();
    if (!faults.empty()) swept.fault = faults.front();
    swept.channel = sweep.bench->structure->estimated;
    stored.push_back(std::move(record));
  }
  const auto faulty = std::ranges::find_if(
      records, [](const SweptRecord& record) { return record.fault.has_value(); });
  const double usual_s = faulty != records.end() ? faulty->fault->at_s : 0.0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const RunRecord& record = stored[i];
    const double at_s = records[i].fault ? records[i].fault->at_s : usual_s;
    const auto sample = [&](double t_s) {
      return static_cast<std::int64_t>(std::max(0.0, t_s) / record.period_s);
    };
    TRY(auto recording,
        api.recordings.Load(record, sample(at_s - kSweptBeforeS), sample(at_s + kSweptAfterS) + 2));
    records[i].samples = std::move(recording.samples);
  }
  FigureContext context;
  context.name = sweep.first.name + " · " + sweep.bench->name;
  context.footer = sweep.Footer();
  TRY(const auto figure, MakeSweptFigure(std::move(records), context));
  return SweepPng(sweep, figure, scale, "curves");
}

json::object ToJson(const SweepRun& run, const std::string& id) {
  return {{"run", id},
          {"component", run.component ? json::value(core::Name(*run.component)) : nullptr},
          {"value", run.component ? json::value(run.value) : nullptr},
          {"named", ListOf(run.named, [](core::Component each) { return core::Name(each); })},
          {"unknown", run.unknown},
          {"found", NumberOrNull(run.found)},
          {"delay_s", NumberOrNull(run.delay_s)}};
}

core::Result<HttpResponse> GetSweep(Api& api, const ApiRequest& request) {
  TRY(const auto sweep, SweepOf(api, request));
  json::array items;
  for (std::size_t i = 0; i < sweep.runs.size(); ++i) {
    items.push_back(ToJson(sweep.runs[i], sweep.ids[i]));
  }
  return JsonResponse(json::object{
      {"batch", sweep.batch}, {"bench", sweep.bench->name}, {"items", std::move(items)}});
}

/// The members of GetSweep in columns, several components with a space between them.
std::string LineOf(const SweepRun& run, const std::string& id) {
  const auto number = [](const std::optional<double>& value) {
    return value ? core::Format("%.9g", *value) : std::string();
  };
  std::string named;
  for (const core::Component each : run.named) {
    named.append(named.empty() ? "" : " ").append(core::Name(each));
  }
  return id + ',' +
         (run.component ? std::string(core::Name(*run.component)) + ',' + number(run.value)
                        : std::string(",")) +
         ',' + named + ',' + (run.unknown ? "true" : "false") + ',' + number(run.found) + ',' +
         number(run.delay_s) + '\n';
}

core::Result<HttpResponse> GetSweepCsv(Api& api, const ApiRequest& request) {
  TRY(const auto jobs, JobsOf(api, request));
  auto spool = api.MakeSpool();
  spool->Append("run,component,value,named,unknown,found,delay_s\n");
  TRY_DONE(VisitSweep(
      api, request, jobs, kOneBench, [&](const Job&, const RunRecord& record, const SweepRun& run) {
        spool->Append(LineOf(run, record.id));
      }));
  const Job& first = jobs.front();
  return Download(std::move(spool),
                  "text/csv; charset=utf-8",
                  FileNameOf(first.created_at, first.name, "sweep", "csv"));
}

/// A line for each job, whatever became of it.
core::Result<HttpResponse> GetBatchLines(Api& api, const ApiRequest& request) {
  TRY(const auto jobs, JobsOf(api, request));
  auto spool = api.MakeSpool();
  std::size_t told = 0;
  const auto without_run = [&](std::size_t to) {
    for (; told < to; ++told) {
      const Job& job = jobs[told];
      spool->Append(json::serialize(json::object{{"job", job.id},
                                                 {"state", job.state},
                                                 {"error", TextOrNull(job.error)},
                                                 {"run", TextOrNull(job.run_id)}}) +
                    '\n');
    }
  };
  const auto seen = VisitSweep(api,
                               request,
                               jobs,
                               !kOneBench,
                               [&](const Job& job, const RunRecord& record, const SweepRun& run) {
                                 without_run(static_cast<std::size_t>(&job - jobs.data()));
                                 json::object line = ToJson(run, record.id);
                                 line["job"] = job.id;
                                 line["state"] = job.state;
                                 spool->Append(json::serialize(line) + '\n');
                                 ++told;
                               });
  const bool none = !seen.ok() && (seen.error().reason == "no_run_finished" ||
                                   seen.error().reason == "batch_hidden");
  if (!seen.ok() && !none) return seen.error();
  without_run(jobs.size());
  const Job& first = jobs.front();
  return Download(std::move(spool),
                  "application/x-ndjson",
                  FileNameOf(first.created_at, first.name, "jobs", "jsonl"));
}

}  // namespace

std::span<const ApiRoute> SweepRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "jobs/batches/{id}/sweep", kSubmitJob, kRole, GetSweep, kNoBody, kHeavy}.Takes(
          "truth"),
      ApiRoute{kGet, "jobs/batches/{id}/sweep.csv", kSubmitJob, kRole, GetSweepCsv, kNoBody, kHeavy}
          .Takes("truth"),
      ApiRoute{
          kGet, "jobs/batches/{id}/jobs.jsonl", kSubmitJob, kRole, GetBatchLines, kNoBody, kHeavy}
          .Takes("truth"),
      ApiRoute{
          kGet, "jobs/batches/{id}/sweep.png", kSubmitJob, kRole, GetSweepPlot, kNoBody, kHeavy}
          .Takes("scale truth"),
      ApiRoute{
          kGet, "jobs/batches/{id}/curves.png", kSubmitJob, kRole, GetCurvesPlot, kNoBody, kHeavy}
          .Takes("scale truth"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
