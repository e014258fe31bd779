// jobs/batches/{id}/sweep.png: what the runs of a batch switched, and what was found.
#include "server/plots/sweep_figure.h"

#include <algorithm>
#include <boost/json.hpp>

#include "server/api/api.h"
#include "server/api/run/file_names.h"
#include "server/api/run/truth.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/experiment/plan_json.h"
#include "server/plots/render.h"

namespace faultlab::server {
namespace {

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

core::Result<HttpResponse> GetSweepPlot(Api& api, const ApiRequest& request) {
  TRY_DONE(OnlyQuery(request.http, {"scale", "truth"}));
  TRY(const auto scale, QueryInteger(request.http, "scale", 1, 1, 2));
  const std::string batch = request.http.PathParameter("id");
  TRY(auto jobs, api.jobs.List("", batch, 0, "", kRunsMax));
  std::erase_if(jobs, [&](const Job& job) { return !MayRead(api, request.who, job); });
  if (jobs.empty()) {
    return core::Refuse("nothing_here");
  }
  std::ranges::reverse(jobs);  // as they were requested
  const core::Bench* bench = nullptr;
  std::vector<SweepRun> runs;
  bool any_hidden = false;
  for (const Job& job : jobs) {
    if (job.state != "finished" || job.run_id.empty()) continue;
    auto stored = api.store.Get(job.run_id);
    if (!stored) continue;  // deleted since
    TRY(const auto record, RunForFile(request.who, request.http, std::move(stored).value()));
    if (IsSealed(record.plan_json)) {
      any_hidden = true;
      continue;
    }
    const auto own = api.benches.OfRecording(record.bench);
    if (!own || (bench != nullptr && own.value() != bench)) continue;
    bench = own.value();
    const auto diagnosis = ParseDiagnosis(record.diagnosis_json, *bench);
    if (diagnosis) runs.push_back(RunOf(record, diagnosis.value(), *bench));
  }
  if (runs.empty() && any_hidden) {
    return core::Refuse("batch_hidden", "truth");
  }
  if (runs.empty()) {
    return core::Refuse("no_run_finished");
  }
  const std::string count = std::to_string(runs.size());
  const std::string footer =
      "faultlab · " + batch + " · " + count + (runs.size() == 1 ? " run" : " runs");
  const auto symbols = bench->components();
  const std::vector<core::Component> components(symbols.begin(), symbols.end());
  const Figure figure =
      MakeSweepFigure(runs, components, jobs.front().name + " · " + bench->name, footer);
  TRY(auto png, RenderPng(figure, {.scale = static_cast<int>(scale)}));
  return Png(std::move(png),
             FileNameOf(jobs.front().created_at, jobs.front().name, "sweep", "png"));
}

}  // namespace

std::span<const ApiRoute> SweepRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "jobs/batches/{id}/sweep.png", kSubmitJob, kRole, GetSweepPlot, kNoBody, kHeavy},
  });
  return kRoutes;
}

}  // namespace faultlab::server
