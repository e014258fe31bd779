#include <boost/json.hpp>

#include "server/api/run/handlers.h"

namespace faultlab::server {
namespace {

core::Result<HttpResponse> GetUsage(Api& api, const ApiRequest& request) {
  TRY(const auto usage, api.quota.Of(request.who));
  const RunQuotaLimits& places = api.places.limits();
  boost::json::object out{{"samples", usage.samples},
                          {"samples_max", nullptr},
                          {"job_bytes", usage.job_bytes},
                          {"job_bytes_max", JobStore::kBodyBytesMax},
                          {"runs_max", places.runs_per_caller_max},
                          {"simulators_max", places.simulators_per_caller}};
  if (usage.samples_max > 0) out["samples_max"] = usage.samples_max;
  return JsonResponse(out);
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
