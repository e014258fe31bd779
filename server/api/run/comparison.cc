// comparison.png: several recordings over each other.
#include "server/plots/comparison_figure.h"

#include <algorithm>

#include "core/diagnosis/diagnose_record.h"
#include "server/api/run/file_names.h"
#include "server/api/run/handlers.h"
#include "server/api/run/truth.h"
#include "server/plots/render.h"

namespace faultlab::server {
namespace {

/// When the rig first changed: as the rig says, else as the diagnosis estimates.
std::optional<double> ChangeOf(const RunStory& story) {
  if (!story.changes.empty()) return story.changes.front().at_s;
  if (story.episodes.empty()) return std::nullopt;
  return story.episodes.front().onset_s;
}

/// Of all runs together.
constexpr std::int64_t kSamplesMax = 1'000'000;

core::Result<ComparedRecord> Compared(Api& api,
                                      RunRecord run,
                                      const LongTurn::Hold& turn,
                                      core::EstimatorId estimator,
                                      bool aligned) {
  TRY(auto review, api.recordings.ReviewOf(std::move(run), turn));
  Recording& recording = review.recording;
  ComparedRecord compared;
  compared.name = recording.record.name.empty() ? recording.record.id : recording.record.name;
  compared.estimated = recording.options.bench->structure->estimated;
  if (aligned) compared.zero_s = ChangeOf(review.story).value_or(0.0);
  compared.curve = EmptyCurve(estimator);
  core::ReplayEstimates(recording.samples, recording.options, [&](const core::Frame& frame) {
    Append(frame, estimator, compared.curve);
  });
  compared.samples = std::move(recording.samples);
  return compared;
}

/// As their files show them.
core::Result<std::vector<RunRecord>> RunsOf(Api& api,
                                            const ApiRequest& request,
                                            const std::vector<std::string>& ids) {
  std::vector<RunRecord> runs;
  for (const std::string& id : ids) {
    TRY(auto found, api.recordings.Find(request.who, id, Operation::kReadRun));
    TRY(auto run, RunForFile(request.who, request.http, std::move(found)));
    runs.push_back(std::move(run));
  }
  return runs;
}

core::Result<LongTurn::Hold> TurnFor(Api& api, const std::vector<RunRecord>& runs) {
  std::int64_t samples = 0;
  for (const RunRecord& run : runs) samples += run.samples;
  if (samples > kSamplesMax) {
    return core::Refuse("compared_too_long", "runs", {{"most", kSamplesMax}});
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
    return core::Refuse("compared_outside", "runs", {{"most", kComparedMax}});
  }
  return ids;
}

core::Result<HttpResponse> GetComparison(Api& api, const ApiRequest& request) {
  TRY(const auto ids, RunsIn(request.http));
  TRY(const auto estimator, EstimatorIn(request.http, core::EstimatorId::kSia100x20));
  TRY(const auto scale, QueryInteger(request.http, "scale", 1, 1, 2));
  TRY(const auto aligned, QueryWord(request.http, "align", {"change", "start"}));
  const std::string align = aligned.value_or("change");
  TRY(auto runs, RunsOf(api, request, ids));
  const RunRecord first = runs.front();
  TRY(const auto turn, TurnFor(api, runs));
  std::vector<ComparedRecord> records;
  for (RunRecord& run : runs) {
    const std::string id = run.id;
    TRY(auto compared, Compared(api, std::move(run), turn, estimator, align == "change"));
    if (compared.samples.size() < 2) {
      core::Error error = core::Refuse("figure_needs_samples", "runs");
      error.message = "Run " + id + ": " + error.message;
      return error;
    }
    records.push_back(std::move(compared));
  }
  std::string footer = "faultlab";
  for (const std::string& id : ids) footer += " · " + id;
  const std::string others = std::to_string(records.size() - 1);
  const std::string kind = records.size() == 1 ? "signals" : "compared-with-" + others;
  const std::string name = FileNameOf(first, kind, "png");
  const EstimatorFamily family = FamilyOf(estimator);
  const Figure figure = MakeComparisonFigure(records, family, align == "change", footer);
  TRY(auto png, RenderPng(figure, {.height_px = 1100, .scale = static_cast<int>(scale)}));
  return Png(std::move(png), name);
}

}  // namespace

std::span<const ApiRoute> ComparisonRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "comparison.png", kReadRun, kObject, GetComparison, kNoBody, kHeavy}.Takes(
          "runs estimator align scale truth"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
