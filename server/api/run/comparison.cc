// comparison.png: several recordings over each other.
#include "server/plots/comparison_figure.h"

#include <algorithm>

#include "core/diagnosis/diagnose_record.h"
#include "server/api/run/file_names.h"
#include "server/api/run/handlers.h"
#include "server/api/run/truth.h"
#include "server/experiment/plan_json.h"
#include "server/plots/render.h"

namespace faultlab::server {
namespace {

core::Result<core::EstimatorId> EstimatorIn(const HttpRequest& request) {
  const std::string name = request.Query("estimator").value_or("sia_100_20");
  const auto shape = std::ranges::find(core::kEstimatorShapes, name, &core::EstimatorShape::name);
  if (shape == core::kEstimatorShapes.end()) {
    return core::Error{core::ErrorCode::kInvalid,
                       "Unknown estimator '" + name + "'.",
                       "estimator",
                       "estimator_unknown"};
  }
  return static_cast<core::EstimatorId>(shape - core::kEstimatorShapes.begin());
}

/// When the rig first changed: as the rig says, else as the diagnosis estimates.
std::optional<double> ChangeOf(const RunStory& story) {
  if (!story.changes.empty()) return story.changes.front().at_s;
  if (story.episodes.empty()) return std::nullopt;
  return story.episodes.front().onset_s;
}

/// Of all runs together.
constexpr std::int64_t kSamplesMax = 1'000'000;

core::Result<ComparedRecord> Compared(RunApi& api,
                                      RunRecord run,
                                      const LongTurn::Hold& turn,
                                      core::EstimatorId estimator,
                                      bool aligned) {
  auto review = api.recordings.ReviewOf(std::move(run), turn);
  if (!review) return review.error();
  Recording& recording = review.value().recording;
  ComparedRecord compared;
  compared.name = recording.record.name.empty() ? recording.record.id : recording.record.name;
  compared.estimated = recording.options.bench->structure->estimated;
  if (aligned) compared.zero_s = ChangeOf(review.value().story).value_or(0.0);
  compared.curve = EmptyCurve(estimator);
  core::ReplayEstimates(recording.samples, recording.options, [&](const core::Frame& frame) {
    Append(frame, estimator, compared.curve);
  });
  compared.samples = std::move(recording.samples);
  return compared;
}

/// As their files show them.
core::Result<std::vector<RunRecord>> RunsOf(RunApi& api,
                                            const ApiRequest& request,
                                            const std::vector<std::string>& ids) {
  std::vector<RunRecord> runs;
  for (const std::string& id : ids) {
    auto found = api.recordings.Find(request.who, id, Operation::kReadRun);
    if (!found) return found.error();
    auto run = RunForFile(request.who, request.http, std::move(found).value());
    if (!run) return run.error();
    runs.push_back(std::move(run).value());
  }
  return runs;
}

core::Result<LongTurn::Hold> TurnFor(RunApi& api, const std::vector<RunRecord>& runs) {
  std::int64_t samples = 0;
  for (const RunRecord& run : runs) samples += run.samples;
  if (samples > kSamplesMax) {
    return core::Error{core::ErrorCode::kInvalid,
                       "Together these runs have more than " + std::to_string(kSamplesMax) +
                           " samples; compare fewer of them.",
                       "runs",
                       "compared_too_long",
                       {{"most", std::to_string(kSamplesMax)}}};
  }
  return api.recordings.long_turn().ForSamples(samples, LongTurn::For::kPerson);
}

/// Each run once, as they were named.
core::Result<std::vector<std::string>> RunsIn(const HttpRequest& request) {
  const std::string text = request.Query("runs").value_or("");
  std::vector<std::string> ids;
  std::size_t at = 0;
  while (at < text.size() && ids.size() <= kComparedMax) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string id = text.substr(at, end - at);
    if (!id.empty() && std::ranges::find(ids, id) == ids.end()) ids.push_back(id);
    at = end + 1;
  }
  if (ids.empty() || ids.size() > kComparedMax) {
    return core::Error{core::ErrorCode::kInvalid,
                       "Give 1 to " + std::to_string(kComparedMax) + " runs: runs=ID,ID.",
                       "runs",
                       "compared_outside",
                       {{"most", std::to_string(kComparedMax)}}};
  }
  return ids;
}

}  // namespace

core::Result<HttpResponse> GetComparison(RunApi& api, const ApiRequest& request) {
  const core::Status query =
      OnlyQuery(request.http, {"runs", "estimator", "align", "scale", "truth"});
  if (!query.ok()) return query.error();
  const auto ids = RunsIn(request.http);
  if (!ids) return ids.error();
  const auto estimator = EstimatorIn(request.http);
  if (!estimator) return estimator.error();
  const auto scale = QueryInteger(request.http, "scale", 1, 1, 2);
  if (!scale) return scale.error();
  const auto aligned = QueryWord(request.http, "align", {"change", "start"});
  if (!aligned) return aligned.error();
  const std::string align = aligned.value().value_or("change");
  auto runs = RunsOf(api, request, ids.value());
  if (!runs) return runs.error();
  const RunRecord first = runs.value().front();
  const auto turn = TurnFor(api, runs.value());
  if (!turn) return turn.error();
  std::vector<ComparedRecord> records;
  for (RunRecord& run : runs.value()) {
    const std::string id = run.id;
    auto compared =
        Compared(api, std::move(run), turn.value(), estimator.value(), align == "change");
    if (!compared) return compared.error();
    if (compared.value().samples.size() < 2) {
      return core::Error{core::ErrorCode::kInvalid,
                         "Run " + id + " has fewer than two samples.",
                         "runs",
                         "figure_needs_samples"};
    }
    records.push_back(std::move(compared).value());
  }
  std::string footer = "faultlab";
  for (const std::string& id : ids.value()) footer += " · " + id;
  const std::string others = std::to_string(records.size() - 1);
  const std::string kind = records.size() == 1 ? "signals" : "compared-with-" + others;
  const std::string name = FileNameOf(first, kind, "png");
  const EstimatorFamily family = FamilyOf(estimator.value());
  const Figure figure = MakeComparisonFigure(records, family, align == "change", footer);
  auto png = RenderPng(figure, {.height_px = 1100, .scale = static_cast<int>(scale.value())});
  if (!png) return png.error();
  HttpResponse response;
  response.content_type = "image/png";
  response.body = std::move(png).value();
  response.headers.emplace_back("Content-Disposition", ContentDisposition("inline", name));
  return response;
}

}  // namespace faultlab::server
