#include <boost/json.hpp>

#include "server/api/run/file_names.h"
#include "server/api/run/handlers.h"
#include "server/api/run/truth.h"
#include "server/experiment/plan_json.h"
#include "server/methods/window_study.h"
#include "server/plots/figure_json.h"
#include "server/plots/render.h"

namespace faultlab::server {
namespace {

core::Result<Figure> FigureOf(Api& api, const ApiRequest& request, const RunRecord& run) {
  const std::string rig = run.rig.empty() ? "" : " · rig " + run.rig;
  return api.recordings.FigureOf(run,
                                 request.http.PathParameter("figure"),
                                 "faultlab · " + run.id + rig + " · " + Iso8601(run.created_at));
}

core::Result<HttpResponse> GetPlot(Api& api, const ApiRequest& request) {
  TRY(auto scale, QueryInteger(request.http, "scale", 1, 1, 2));
  TRY(const auto run, RunForFile(request));
  TRY(auto figure, FigureOf(api, request, run));
  RenderOptions options;
  options.scale = static_cast<int>(scale);
  TRY(auto png, RenderPng(figure, options));
  const std::string kind = request.http.PathParameter("figure") + (options.scale == 1 ? "" : "_2x");
  return Png(std::move(png), FileNameOf(request.run, kind, "png"));
}

core::Result<HttpResponse> GetFigure(Api& api, const ApiRequest& request) {
  TRY(auto figure, FigureOf(api, request, request.run));
  return JsonResponse(ToJson(figure));
}

/// Windows and orders over the recording, as `faultlab study` does.
core::Result<HttpResponse> GetStudy(Api& api, const ApiRequest& request) {
  constexpr double kLongestS = 1e6;
  constexpr std::size_t kStudyWorkMax = 2'000'000;  // some seconds
  const HttpRequest& http = request.http;
  StudyRequest asked;
  asked.windows = http.Query("k").value_or(asked.windows);
  asked.integrals = http.Query("km").value_or(asked.integrals);
  asked.orders = http.Query("order").value_or(asked.orders);
  asked.change = http.Query("change").value_or(asked.change);
  TRY(asked.from_s, QueryNumber(http, "from_s", asked.from_s, 0.0, kLongestS));
  TRY(const auto exact, QueryWord(http, "exact", {"true", "false"}));
  TRY(const auto affine, QueryWord(http, "affine", {"true", "false"}));
  asked.exact = exact == "true";
  asked.affine = affine == "true";
  if (IsSealed(request.run.plan_json)) return core::Refuse("run_sealed");
  TRY(const auto review, api.recordings.ReviewOf(request.run));
  const core::DiagnosisOptions& options = review.recording.options;
  const auto& calibration = review.diagnosis.calibration;
  TRY(const auto study,
      StudyRecord(asked,
                  {review.recording.samples,
                   *options.bench,
                   options.period_s,
                   calibration ? calibration->delta_s : 0.0,
                   review.story.ChangeTimes(),
                   kStudyWorkMax}));
  return JsonResponse(ToJson(study));
}

}  // namespace

std::span<const ApiRoute> FiguresRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "runs/{id}/plots/{figure}.png", kReadRun, kRun, GetPlot, kNoBody, kHeavy}
          .Takes("scale truth"),
      {kGet, "runs/{id}/figures/{figure}", kReadRun, kRun, GetFigure, kNoBody, kHeavy},
      ApiRoute{kGet, "runs/{id}/study", kReadRun, kRun, GetStudy, kNoBody, kHeavy}.Takes(
          "k km order change from_s exact affine"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
