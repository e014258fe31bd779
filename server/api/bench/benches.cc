// What the bench of a rig is, and the model that its parts give: for everybody, the same for all.
#include <algorithm>
#include <boost/json.hpp>
#include <charconv>
#include <functional>

#include "hardware/rig.h"
#include "server/api/bench/bench_json.h"
#include "server/api/bench/benches.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr const char* kMinute = "public, max-age=60";
/// Farther from nominal the parameters of the model leave what a number can hold.
constexpr double kFactorMax = 1e9;

struct Document {
  std::string text;
  std::string etag;
};

const Document& Benches() {
  static const Document document = [] {
    Document made;
    made.text = json::serialize(json::object{{"items", json::array{PaperBenchToJson()}}});
    made.etag = "\"" + std::to_string(std::hash<std::string>{}(made.text)) + "\"";
    return made;
  }();
  return document;
}

struct NumberRule {
  double fallback;
  double lo;
  double hi;
  const char* refusal;
};

core::Result<double> QueryNumber(const HttpRequest& request,
                                 std::string_view name,
                                 const NumberRule& rule) {
  const auto text = request.Query(name);
  if (!text) return rule.fallback;
  double value = 0.0;
  const char* end = text->data() + text->size();
  const auto [parsed_to, error] = std::from_chars(text->data(), end, value);
  if (error != std::errc{} || parsed_to != end || !(value >= rule.lo && value <= rule.hi)) {
    return core::Error{core::ErrorCode::kInvalid, rule.refusal, std::string(name)};
  }
  return value;
}

/// The nominal plant, or with the component that the query changes.
core::Result<core::PlantParameters> QueryPlant(const HttpRequest& request) {
  core::PlantParameters plant;
  const auto name = request.Query("component");
  if (name.has_value() != request.Query("value").has_value()) {
    return core::Error{
        core::ErrorCode::kInvalid, "Give 'component' and 'value' together.", "component"};
  }
  if (!name) return plant;
  const auto component = core::ParseComponent(*name);
  if (!component) {
    return core::Error{
        core::ErrorCode::kInvalid, "This bench has no component '" + *name + "'.", "component"};
  }
  const double nominal = plant.Get(*component);
  const auto value = QueryNumber(
      request,
      "value",
      {nominal,
       nominal / kFactorMax,
       nominal * kFactorMax,
       "'value' must be above 0, in the SI unit, not farther than a billion times from nominal."});
  if (!value) return value.error();
  plant.Set(*component, value.value());
  return plant;
}

core::Result<HttpResponse> ListBenches(const ApiRequest& request) {
  const core::Status known = OnlyQuery(request.http, {});
  if (!known.ok()) return known.error();
  HttpResponse response;
  response.headers.emplace_back("ETag", Benches().etag);
  response.headers.emplace_back("Cache-Control", kMinute);
  if (request.http.Header("If-None-Match").find(Benches().etag) != std::string_view::npos) {
    response.status = 304;
  } else {
    response.static_body = Benches().text;
  }
  return response;
}

core::Result<HttpResponse> GetBenchModel(const ApiRequest& request) {
  const core::Status known = OnlyQuery(request.http, {"component", "value", "period_s", "delta_s"});
  if (!known.ok()) return known.error();
  if (request.http.PathParameter("bench") != kPaperBench) {
    return core::Error{core::ErrorCode::kNotFound, "There is no such bench.", ""};
  }
  const auto plant = QueryPlant(request.http);
  if (!plant) return plant.error();
  const auto period_s = QueryNumber(
      request.http,
      "period_s",
      {core::kSamplePeriodSeconds, 1e-3, 1.0, "'period_s' must lie between 1 ms and 1 s."});
  if (!period_s) return period_s.error();
  const auto delta_s = QueryNumber(request.http,
                                   "delta_s",
                                   {std::min(hardware::RigDescription{}.delta_s, period_s.value()),
                                    0.0,
                                    period_s.value(),
                                    "'delta_s' must lie in the period."});
  if (!delta_s) return delta_s.error();
  HttpResponse response =
      JsonResponse(ModelToJson(plant.value(), period_s.value(), delta_s.value()));
  response.headers.emplace_back("Cache-Control", kMinute);
  return response;
}

}  // namespace

std::vector<ApiRoute> BenchRoutes() {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  return {
      {kGet, "/api/v1/benches", kReadPublic, kOpen, ListBenches},
      {kGet, "/api/v1/benches/{bench}/model", kReadPublic, kOpen, GetBenchModel},
  };
}

}  // namespace faultlab::server
