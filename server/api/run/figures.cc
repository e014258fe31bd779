#include <boost/json.hpp>

#include "server/api/run/file_names.h"
#include "server/api/run/handlers.h"
#include "server/api/run/truth.h"
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
  TRY_DONE(OnlyQuery(request.http, {"scale", "truth"}));
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

}  // namespace

std::span<const ApiRoute> FiguresRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "runs/{id}/plots/{figure}.png", kReadRun, kRun, GetPlot, kNoBody, kHeavy},
      {kGet, "runs/{id}/figures/{figure}", kReadRun, kRun, GetFigure, kNoBody, kHeavy},
  });
  return kRoutes;
}

}  // namespace faultlab::server
