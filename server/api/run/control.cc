// How well a run under speed control kept its reference.
#include <boost/json.hpp>
#include <cmath>

#include "server/api/run/handlers.h"
#include "server/experiment/control_account.h"
#include "server/experiment/plan_json.h"
#include "server/json/number_or_null.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

json::value Hundredths(double n_rpm) {
  constexpr double kSteps = 100.0;
  if (!std::isfinite(n_rpm)) return nullptr;
  return std::round(n_rpm * kSteps) / kSteps;
}

json::value QualityToJson(const ControlAccount& account, std::span<const core::Sample> samples) {
  const auto quality = QualityOf(account, samples);
  if (!quality) return nullptr;
  return json::object{{"from_s", static_cast<double>(account.judged_from) * account.period_s},
                      {"iae_rad", quality->iae_rad},
                      {"late_iae_rad", quality->late_iae_rad},
                      {"overshoot_percent", quality->overshoot_percent},
                      {"settling_s", NumberOrNull(quality->settling_s)},
                      {"steady_error_rad_s", quality->steady_error_rad_s}};
}

json::object ReferenceToJson(const ControlAccount& account, const Recording& recording) {
  const ReferenceCorners corners = CornersOf(account.planned,
                                             *recording.options.bench,
                                             account.period_s,
                                             SecondsOfPlan(recording.record.plan_json));
  return {{"t_s", ListOf(corners.t_s)}, {"n_rpm", ListOf(corners.n_rpm, Hundredths)}};
}

json::array CompensationsToJson(const ControlAccount& account) {
  return ListOf(account.compensations, [](const Compensation& each) {
    return json::object{{"t_s", each.t_s},
                        {"component", core::Name(each.component)},
                        {"value", each.value},
                        {"until_s", NumberOrNull(each.until_s)},
                        {"ended", TextOrNull(each.ended)}};
  });
}

json::array VisibleToJson(std::span<const core::VisibleChange> changes) {
  return ListOf(changes, [](const core::VisibleChange& change) {
    return json::object{{"component", change.symbol},
                        {"from_percent", NumberOrNull(100.0 * change.share)}};
  });
}

json::value WithoutToJson(const ControlAccount& account, const Review& review) {
  const auto without = WithoutDiagnosis(account, review);
  if (!without) return nullptr;
  json::array n_rpm;
  for (std::size_t k = *account.began; k < without->size(); ++k) {
    n_rpm.push_back(Hundredths((*without)[k].n_rpm));
  }
  return json::object{{"from_s", static_cast<double>(*account.began) * account.period_s},
                      {"n_rpm", std::move(n_rpm)},
                      {"quality", QualityToJson(account, *without)}};
}

core::Result<HttpResponse> GetControl(Api& api, const ApiRequest& request) {
  TRY(const auto without, QueryWord(request.http, "without", {"include"}));
  TRY(const auto review, api.recordings.ReviewOf(request.run));
  const auto account = AccountOf(review);
  if (!account) {
    return core::Refuse("run_without_control");
  }
  json::object out{{"from_s", account->planned.from_s},
                   {"began_s", nullptr},
                   {"controller", core::Name(account->planned.wanted.options.kind)},
                   {"reference", ReferenceToJson(*account, review.recording)},
                   {"compensations", CompensationsToJson(*account)},
                   {"reachable_rad_s", NumberOrNull(account->reachable_rad_s)},
                   {"accommodated", nullptr},
                   {"dither_rad_s", NumberOrNull(account->dither_rad_s)},
                   {"visible", VisibleToJson(account->visible)},
                   {"quality", QualityToJson(*account, review.recording.samples)},
                   {"without", nullptr}};
  if (account->began) out["began_s"] = static_cast<double>(*account->began) * account->period_s;
  if (account->reachable_rad_s) {
    out["accommodated"] = account->planned.wanted.reference.highest() <= *account->reachable_rad_s;
  }
  const bool ended = request.run.state != RunState::kRunning;
  if (without && ended) out["without"] = WithoutToJson(*account, review);
  return JsonResponse(out);
}

}  // namespace

std::span<const ApiRoute> ControlRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "runs/{id}/control", kReadRun, kRun, GetControl, kNoBody, kHeavy}.Takes(
          "without"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
