#include <boost/json.hpp>

#include "server/api/run/handlers.h"

namespace faultlab::server {
namespace {

core::Result<HttpResponse> GetUsage(Api& api, const ApiRequest& request) {
  TRY(const auto usage, api.quota.Of(request.who));
  const RunQuotaLimits& places = api.places.limits();
  const std::int64_t most = usage.samples_max;
  return JsonResponse(
      boost::json::object{{"samples", usage.samples},
                          {"samples_max", most > 0 ? boost::json::value(most) : nullptr},
                          {"job_bytes", usage.job_bytes},
                          {"job_bytes_max", JobStore::kBodyBytesMax},
                          {"runs_max", places.runs_per_caller_max},
                          {"simulators_max", places.simulators_per_caller}});
}

}  // namespace

std::span<const ApiRoute> UsageRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      {kGet, "usage", kReadRun, kObject, GetUsage},
  });
  return kRoutes;
}

}  // namespace faultlab::server
