// What the benches are, and the models that their parts give: for everybody, the same for all.
#include <algorithm>
#include <boost/json.hpp>
#include <string>
#include <utility>

#include "server/api/api.h"
#include "server/api/bench/bench_json.h"
#include "server/run/refusals.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr const char* kMinute = "public, max-age=60";
/// An id stands for what one file says; of two files that say the same, the comments may differ.
constexpr const char* kForEver = "public, max-age=31536000, immutable";
/// Farther from nominal the parameters of the model leave what a number can hold.
constexpr double kFactorMax = 1e9;

/// The nominal plant, or with the component that the query changes.
core::Result<core::PlantParameters> QueryPlant(const HttpRequest& request,
                                               const core::Bench& bench) {
  core::PlantParameters plant = bench.nominal;
  const auto name = request.Query("component");
  if (name.has_value() != request.Query("value").has_value()) {
    return core::Refuse("component_and_value", "component");
  }
  if (!name) return plant;
  const auto component = bench.Find(*name);
  if (!component) {
    return refusal::NoComponent(bench, *name);
  }
  const double nominal = plant.Get(*component);
  TRY(const auto value,
      QueryNumber(request, "value", nominal, nominal / kFactorMax, nominal * kFactorMax));
  plant.Set(*component, value);
  return plant;
}

core::Result<HttpResponse> ListBenches(Api& api, const ApiRequest& request) {
  TRY(const auto list, api.benches.List());
  std::string etag = "\"";
  for (const core::Bench* bench : list) etag += bench->id + " ";
  etag.back() = '"';
  HttpResponse response;
  if (request.http.Header("If-None-Match").find(etag) != std::string_view::npos) {
    response.status = 304;
  } else {
    const auto to_json = [](const core::Bench* bench) { return BenchToJson(*bench); };
    response = JsonResponse(json::object{{"items", ListOf(list, to_json)}});
  }
  response.headers.emplace_back("ETag", std::move(etag));
  response.headers.emplace_back("Cache-Control", kMinute);
  return response;
}

/// The bench of the path, with how long what is said of it stays true.
struct AskedBench {
  const core::Bench* bench = nullptr;
  const char* cache_control = kMinute;
};

core::Result<AskedBench> BenchAsked(Api& api, const ApiRequest& request) {
  const std::string& name = request.http.PathParameter("bench");
  const auto bench = api.benches.Find(name);
  if (!bench) return refusal::At(bench.error(), "");
  return AskedBench{bench.value(), bench.value()->id == name ? kForEver : kMinute};
}

core::Result<HttpResponse> GetBench(Api& api, const ApiRequest& request) {
  TRY(const auto asked, BenchAsked(api, request));
  HttpResponse response = JsonResponse(BenchToJson(*asked.bench));
  response.headers.emplace_back("Cache-Control", asked.cache_control);
  return response;
}

core::Result<HttpResponse> GetBenchFile(Api& api, const ApiRequest& request) {
  TRY(const auto asked, BenchAsked(api, request));
  HttpResponse response;
  response.content_type = "application/toml; charset=utf-8";
  response.body = asked.bench->text;
  response.headers.emplace_back("Cache-Control", kMinute);
  response.headers.emplace_back("Content-Disposition",
                                "attachment; filename=\"" + asked.bench->name + ".toml\"");
  return response;
}

core::Result<HttpResponse> GetBenchModel(Api& api, const ApiRequest& request) {
  TRY(const auto asked, BenchAsked(api, request));
  const core::Bench& bench = *asked.bench;
  TRY(const auto plant, QueryPlant(request.http, bench));
  TRY(const auto period_s, QueryNumber(request.http, "period_s", bench.period_s, 1e-3, 1.0));
  TRY(const auto delta_s,
      QueryNumber(request.http, "delta_s", std::min(bench.delta_s, period_s), 0.0, period_s));
  HttpResponse response = JsonResponse(ModelToJson(plant, period_s, delta_s));
  response.headers.emplace_back("Cache-Control", asked.cache_control);
  return response;
}

}  // namespace

std::span<const ApiRoute> BenchesRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "benches", kReadPublic, kOpen, ListBenches},
      {kGet, "benches/{bench}", kReadPublic, kOpen, GetBench},
      {kGet, "benches/{bench}/file", kReadPublic, kOpen, GetBenchFile},
      ApiRoute{kGet, "benches/{bench}/model", kReadPublic, kOpen, GetBenchModel}.Takes(
          "component value period_s delta_s"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
