#include <boost/json.hpp>
#include <cmath>

#include "server/api/handlers.h"
#include "server/api/run_body.h"
#include "server/plots/figure_json.h"
#include "server/plots/record_figure.h"
#include "server/plots/render.h"

namespace faultlab::server {
namespace {

constexpr std::int64_t kIndexMax = 1'000'000'000;

core::Result<Figure> FigureOf(ApiContext& api, const ApiRequest& request) {
  auto loaded = AuthorizedRun(api, request, Operation::kReadRun);
  if (!loaded) return loaded.error();
  const RunRecord& record = loaded.value();
  auto samples = api.store.LoadSamples(record.id, 0, kIndexMax);
  if (!samples) return samples.error();
  core::DiagnoseOptions options;
  options.period_s = record.period_s;
  options.values = core::ValuePrior::kNone;
  FigureContext context;
  context.name = record.name.empty() ? record.id : record.name;
  context.footer = "faultlab · " + record.id +
                   (record.rig.empty() ? std::string() : " · rig " + record.rig) + " · " +
                   Iso8601(record.created_at);
  context.faults = FaultsOfPlan(record.plan_json);
  const std::string& name = request.http.PathParameter("figure");
  const core::Status fit = CheckFigure(name, samples.value());
  if (!fit.ok()) return fit.error();
  const auto diagnose = [&] { return core::DiagnoseRecord(samples.value(), options); };
  if (record.state == RunState::kRunning) {
    return MakeFigure(name, samples.value(), options, diagnose(), std::move(context));
  }
  const auto diagnosis = api.diagnoses.Get(record.id, diagnose);
  return MakeFigure(name, samples.value(), options, *diagnosis, std::move(context));
}

}  // namespace

core::Result<HttpResponse> GetPlot(ApiContext& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {"scale"});
  if (!query.ok()) return query.error();
  auto scale = QueryInteger(request.http, "scale", 1, 1, 2);
  if (!scale) return scale.error();
  auto figure = FigureOf(api, request);
  if (!figure) return figure.error();
  RenderOptions options;
  options.scale = static_cast<int>(scale.value());
  auto png = RenderPng(figure.value(), options);
  if (!png) return png.error();
  HttpResponse response;
  response.content_type = "image/png";
  response.body = std::move(png).value();
  response.headers.emplace_back("Content-Disposition",
                                "inline; filename=\"" + request.http.PathParameter("id") + "-" +
                                    request.http.PathParameter("figure") + ".png\"");
  return response;
}

core::Result<HttpResponse> GetFigure(ApiContext& api, const ApiRequest& request) {
  auto figure = FigureOf(api, request);
  if (!figure) return figure.error();
  return JsonResponse(ToJson(figure.value()));
}

}  // namespace faultlab::server
