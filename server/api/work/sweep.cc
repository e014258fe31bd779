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

constexpr int kRunsMax = 500;

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
  std::vector<RunRecord> records;
  std::vector<SweepRun> runs;  ///< of the same

  std::string Footer() const {
    const std::string count = std::to_string(runs.size());
    return "faultlab · " + batch + " · " + count + (runs.size() == 1 ? " run" : " runs");
  }
};

core::Result<Sweep> SweepOf(Api& api, const ApiRequest& request) {
  Sweep sweep;
  sweep.batch = request.http.PathParameter("id");
  TRY(auto jobs, api.jobs.List("", sweep.batch, 0, "", kRunsMax));
  std::erase_if(jobs, [&](const Job& job) { return !MayRead(api, request.who, job); });
  if (jobs.empty()) {
    return core::Refuse("nothing_here");
  }
  std::ranges::reverse(jobs);  // as they were requested
  bool any_hidden = false;
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
    if (!own || (sweep.bench != nullptr && own.value() != sweep.bench)) continue;
    sweep.bench = own.value();
    const auto diagnosis = ParseDiagnosis(record.diagnosis_json, *sweep.bench);
    if (!diagnosis) continue;
    sweep.runs.push_back(RunOf(record, diagnosis.value(), *sweep.bench));
    sweep.records.push_back(std::move(record));
  }
  if (sweep.runs.empty()) {
    return any_hidden ? core::Refuse("batch_hidden", "truth") : core::Refuse("no_run_finished");
  }
  sweep.first = jobs.front();
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
  if (sweep.records.size() > kSweptMax) {
    return core::Refuse("curves_too_many", "", {{"most", kSweptMax}, {"runs", sweep.runs.size()}});
  }
  std::vector<SweptRecord> records;
  for (const RunRecord& record : sweep.records) {
    const std::vector<core::Fault> faults = FaultsOfPlan(record.plan_json, *sweep.bench);
    SweptRecord& swept = records.emplace_back();
    if (!faults.empty()) swept.fault = faults.front();
    swept.channel = sweep.bench->structure->estimated;
  }
  const auto faulty = std::ranges::find_if(
      records, [](const SweptRecord& record) { return record.fault.has_value(); });
  const double usual_s = faulty != records.end() ? faulty->fault->at_s : 0.0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const RunRecord& record = sweep.records[i];
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
    items.push_back(ToJson(sweep.runs[i], sweep.records[i].id));
  }
  return JsonResponse(json::object{
      {"batch", sweep.batch}, {"bench", sweep.bench->name}, {"items", std::move(items)}});
}

/// The members of GetSweep in columns, several components with a space between them.
core::Result<HttpResponse> GetSweepCsv(Api& api, const ApiRequest& request) {
  TRY(const auto sweep, SweepOf(api, request));
  std::string text = "run,component,value,named,unknown,found,delay_s\n";
  const auto number = [](const std::optional<double>& value) {
    return value ? core::Format("%.9g", *value) : std::string();
  };
  for (std::size_t i = 0; i < sweep.runs.size(); ++i) {
    const SweepRun& run = sweep.runs[i];
    std::string named;
    for (const core::Component each : run.named) {
      named.append(named.empty() ? "" : " ").append(core::Name(each));
    }
    text += sweep.records[i].id + ',' +
            (run.component ? std::string(core::Name(*run.component)) + ',' + number(run.value)
                           : std::string(",")) +
            ',' + named + ',' + (run.unknown ? "true" : "false") + ',' + number(run.found) + ',' +
            number(run.delay_s) + '\n';
  }
  auto spool = api.MakeSpool();
  spool->Append(text);
  return Download(std::move(spool),
                  "text/csv; charset=utf-8",
                  FileNameOf(sweep.first.created_at, sweep.first.name, "sweep", "csv"));
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
          kGet, "jobs/batches/{id}/sweep.png", kSubmitJob, kRole, GetSweepPlot, kNoBody, kHeavy}
          .Takes("scale truth"),
      ApiRoute{
          kGet, "jobs/batches/{id}/curves.png", kSubmitJob, kRole, GetCurvesPlot, kNoBody, kHeavy}
          .Takes("scale truth"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
