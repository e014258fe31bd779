// Recordings to learn from, and what the estimators and the detection bank make of them.
#include "server/api/api.h"

#include <boost/json.hpp>
#include <cmath>
#include <string>
#include <utility>

#include "server/demonstration/demonstration.h"
#include "server/demonstration/estimate_study.h"
#include "server/run/refusals.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr const char* kHour = "public, max-age=3600";
constexpr double kNoisePercentMax = 100.0;
constexpr double kRateMin = 1e-3;
constexpr double kRateMax = 1e5;
/// More than a picture of it shows.
constexpr int kDigits = 6;
/// No parameter's estimates are asked for.
constexpr std::int64_t kNone = -1;
/// Samples before and after the changes.
constexpr std::size_t kSamplesShown = 200;

struct Asked {
  const core::Bench* bench = nullptr;
  std::vector<core::Fault> changes;
};

core::Result<Asked> AskedOf(Api& api, const ApiRequest& request) {
  const auto bench = api.benches.Find(request.http.PathParameter("bench"));
  if (!bench) return refusal::At(bench.error(), "");
  TRY(auto changes,
      ParseChanges(request.http.Query("changes").value_or(std::string()), *bench.value()));
  return Asked{bench.value(), std::move(changes)};
}

/// One of two words, the first by default.
core::Result<bool> QuerySecond(const HttpRequest& http,
                               const std::string& name,
                               const std::string& first,
                               const std::string& second) {
  const std::string word = http.Query(name).value_or(first);
  if (word == first || word == second) return word == second;
  const std::string words = "'" + first + "', '" + second + "'";
  return core::Refuse("word_unknown", name, {{"member", name}, {"words", words}});
}

json::value SixDigits(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0.0) return 0.0;
  const double scale = std::pow(10.0, kDigits - 1 - std::floor(std::log10(std::abs(value))));
  return std::isfinite(scale) ? std::round(value * scale) / scale : 0.0;
}

json::value SixDigits(const std::optional<double>& value) {
  return value ? SixDigits(*value) : json::value(nullptr);
}

json::array SixDigits(const std::vector<double>& values) {
  return ListOf(values, [](double value) { return SixDigits(value); });
}

HttpResponse CachedAnswer(json::object body) {
  HttpResponse response = JsonResponse(std::move(body));
  response.headers.emplace_back("Cache-Control", kHour);
  return response;
}

core::Result<HttpResponse> GetDemonstration(Api& api, const ApiRequest& request) {
  TRY(const auto asked, AskedOf(api, request));
  const core::Bench& bench = *asked.bench;
  TRY(const auto played, PlayDemonstration(bench, asked.changes, {}));
  const std::size_t first = played.fault_at - kSamplesShown;
  const auto column = [&](double core::Sample::*reading) {
    return ListOf(std::span(played.samples).subspan(first, 2 * kSamplesShown),
                  [&](const core::Sample& sample) { return SixDigits(sample.*reading); });
  };
  const core::PlantParameters plant = ChangedPlant(bench, asked.changes);
  json::object channels{{"uc", column(&core::Sample::uc_v)}};
  if (bench.um.exists) channels["um"] = column(&core::Sample::um_v);
  if (bench.ua.exists) channels["ua"] = column(&core::Sample::ua_v);
  if (bench.ia.exists) channels["ia"] = column(&core::Sample::ia_a);
  if (bench.n.exists) channels["n"] = column(&core::Sample::n_rpm);
  return CachedAnswer({{"period_s", bench.period_s},
                       {"first_index", first},
                       {"fault_at_s", static_cast<double>(played.fault_at) * bench.period_s},
                       {"gain", plant.gain()},
                       {"channels", std::move(channels)}});
}

core::Result<EstimateQuestion> QuestionOf(const ApiRequest& request, Asked asked) {
  const HttpRequest& http = request.http;
  EstimateQuestion question;
  question.changes = std::move(asked.changes);
  TRY(const auto sia, QuerySecond(http, "method", "swa", "sia"));
  question.method = sia ? core::EstimatorMethod::kSia : core::EstimatorMethod::kSwa;
  TRY(const auto paper, QuerySecond(http, "rule", "exact", "paper"));
  question.sia_mode = paper ? core::SiaMode::kPaper : core::SiaMode::kExact;
  TRY(const auto window, QueryInteger(http, "window", 100, 6, kStudyWindowMax));
  question.window_samples = static_cast<int>(window);
  TRY(const auto integral, QueryInteger(http, "integral", sia ? 20 : 0, 0, kStudyWindowMax - 1));
  question.integral_samples = static_cast<int>(integral);
  TRY(question.added_noise_percent, QueryNumber(http, "noise_percent", 0.0, 0.0, kNoisePercentMax));
  return question;
}

core::Result<HttpResponse> GetEstimateStudy(Api& api, const ApiRequest& request) {
  TRY(auto asked, AskedOf(api, request));
  const core::Bench& bench = *asked.bench;
  TRY(const auto question, QuestionOf(request, std::move(asked)));
  TRY(const auto shown, QueryInteger(request.http, "parameter", kNone, 0, 2));
  TRY(const auto study, StudyEstimates(bench, question));
  const auto parameter_to_json = [](const EstimateStudy::Parameter& each) {
    return json::object{{"name", each.name},
                        {"nominal", SixDigits(each.nominal)},
                        {"changed", SixDigits(each.changed)},
                        {"mean", SixDigits(each.mean)},
                        {"mean_after", SixDigits(each.mean_after)},
                        {"deviation", SixDigits(each.deviation)},
                        {"delay_s", SixDigits(each.delay_s)}};
  };
  const bool none = shown == kNone;
  const auto which = static_cast<std::size_t>(none ? 0 : shown);
  return CachedAnswer(
      {{"period_s", bench.period_s},
       {"fault_at_s", study.fault_at_s},
       {"added_noise", SixDigits(study.added_noise)},
       {"settle_s", SixDigits(study.settle_s)},
       {"parameters", ListOf(study.parameters, parameter_to_json)},
       {"estimates", none ? json::array() : SixDigits(study.parameters[which].estimates)}});
}

core::Result<HttpResponse> GetDetection(Api& api, const ApiRequest& request) {
  TRY(const auto asked, AskedOf(api, request));
  TRY(const auto rate, QueryNumber(request.http, "false_alarms_per_day", 1.0, kRateMin, kRateMax));
  const core::Bench& bench = *asked.bench;
  TRY(const auto found, api.studies.Study(bench, asked.changes, rate));
  return CachedAnswer({{"period_s", bench.period_s},
                       {"fault_at_s", found.fault_at_s},
                       {"watched_from_s", found.watched_from_s},
                       {"false_alarms_s", SixDigits(found.false_alarms_s)},
                       {"delay_s", SixDigits(found.delay_s)},
                       {"detector", found.detector},
                       {"block_samples", found.block_samples},
                       {"level", SixDigits(found.level)}});
}

}  // namespace

std::span<const ApiRoute> DemonstrationsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "benches/{bench}/demonstration", kReadPublic, kAnybody, GetDemonstration}
          .Takes("changes"),
      ApiRoute{
          kGet, "benches/{bench}/demonstration/estimates", kReadPublic, kAnybody, GetEstimateStudy}
          .Takes("changes method window integral rule noise_percent parameter"),
      ApiRoute{kGet,
               "benches/{bench}/demonstration/detection",
               kReadPublic,
               kAnybody,
               GetDetection,
               kNoBody,
               kHeavy}
          .Takes("changes false_alarms_per_day"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
