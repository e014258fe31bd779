// fault-sets/{id}/isolability: which faults of a set can be seen and told apart.
#include <algorithm>
#include <boost/json.hpp>

#include "core/signals/excitation_text.h"
#include "core/types/number_text.h"
#include "server/api/api.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/diagnosis_json/isolability_json.h"
#include "server/diagnosis_json/isolability_question.h"
#include "server/experiment/plan_json.h"
#include "server/plots/isolability_figure.h"
#include "server/plots/render.h"

namespace faultlab::server {
namespace {

constexpr std::int64_t kWindowMin = 10;
constexpr std::int64_t kWindowMax = 500;  // five seconds of a fault; a second of work

/// The newest that a run has learnt about the rig.
core::Result<core::Calibration> NewestCalibration(Api& api,
                                                  const std::string& rig,
                                                  const core::Bench& bench) {
  if (!IsKnown(api.service, api.rig_pool, rig)) {
    return core::Refuse("no_rig", "rig", {{"rig", rig}}).As(core::ErrorCode::kInvalid);
  }
  constexpr int kLookedAt = 10;
  TRY(const auto rows, api.calibrations.List(rig, bench.id, kLookedAt));
  if (rows.empty()) {
    return core::Refuse("rig_not_calibrated", "rig", {{"rig", rig}, {"bench", bench.name}});
  }
  // One that runs may start with tells more of the rig than a guest's.
  const auto fit = std::ranges::find_if(rows, &std::string::empty, &RigCalibration::unfit);
  const RigCalibration& best = fit == rows.end() ? rows.front() : *fit;
  return ParseCalibration(best.json, "The stored calibration of " + rig, bench);
}

core::Status SetExcitation(const HttpRequest& request, IsolabilityQuestion& question) {
  question.excitation_name = request.Query("excitation").value_or(question.excitation_name);
  TRY(question.excitation, core::ParseExcitation(question.excitation_name, 1));
  return core::Done{};
}

core::Result<IsolabilityQuestion> IsolabilityAsked(Api& api,
                                                   const ApiRequest& request,
                                                   const FaultSet& set) {
  const HttpRequest& http = request.http;
  IsolabilityQuestion question;
  TRY(question.bench, api.benches.Find(set.bench));
  question.excitation_name = question.bench->excitation_text;
  TRY(auto window,
      QueryInteger(http, "window_samples", question.window_samples, kWindowMin, kWindowMax));
  question.window_samples = static_cast<int>(window);
  question.channels = http.Query("channels").value_or(question.channels);
  question.profile = http.Query("profile").value_or(question.profile);
  if (const auto text = http.Query("um_noise_v")) {
    question.um_noise_v =
        core::ParseNumber(*text).value_or(0.0);  // which is refused with its limits
  }
  if (const core::Status set_one = SetExcitation(http, question); !set_one) return set_one.error();
  if (const auto rig = http.Query("rig")) {
    TRY(question.calibration, NewestCalibration(api, *rig, *question.bench));
  }
  TRY(const auto faults, ParseFaults(set.faults_json, *question.bench, kRunSecondsMax));
  for (const core::Fault& fault : faults) {
    question.faults.push_back({fault.component, fault.value});
  }
  return question;
}

struct Answer {
  FaultSet set;
  IsolabilityQuestion question;
  core::Isolability isolability;
};

core::Result<Answer> JudgeQuestion(Api& api, const ApiRequest& request) {
  TRY(auto id, PathNumber(request));
  TRY(auto set, api.fault_set_access.Find(request.who, id, Operation::kReadFaultSet));
  TRY(auto question, IsolabilityAsked(api, request, set));
  TRY(const auto options, ToOptions(question));
  TRY(auto isolability, core::AnalyseIsolability(options));
  return Answer{std::move(set), std::move(question), std::move(isolability)};
}

core::Result<HttpResponse> GetIsolability(Api& api, const ApiRequest& request) {
  TRY(const auto answer, JudgeQuestion(api, request));
  return JsonResponse(ToJson(answer.isolability));
}

core::Result<HttpResponse> GetIsolabilityPlot(Api& api, const ApiRequest& request) {
  TRY(const auto judged, JudgeQuestion(api, request));
  const std::string subtitle = judged.set.name + ": " + ToText(judged.question);
  TRY(auto png, RenderPng(MakeIsolabilityFigure(judged.isolability, subtitle), RenderOptions{}));
  return Png(std::move(png), "fault-set-" + std::to_string(judged.set.id) + "-isolability.png");
}

}  // namespace

std::span<const ApiRoute> IsolabilityRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet,
               "fault-sets/{id}/isolability",
               kReadFaultSet,
               kRole,
               GetIsolability,
               kNoBody,
               kHeavy}
          .Takes("channels window_samples rig profile um_noise_v excitation"),
      ApiRoute{kGet,
               "fault-sets/{id}/isolability.png",
               kReadFaultSet,
               kRole,
               GetIsolabilityPlot,
               kNoBody,
               kHeavy}
          .Takes("channels window_samples rig profile um_noise_v excitation"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
