#include <boost/json.hpp>

#include "server/api/run/handlers.h"

namespace faultlab::server {

core::Result<HttpResponse> GetUsage(RunApi& api, const ApiRequest& request) {
  const auto usage = api.quota.Of(request.who);
  if (!usage) return usage.error();
  const RunQuotaLimits& places = api.places.limits();
  boost::json::object out{{"samples", usage.value().samples},
                          {"samples_max", nullptr},
                          {"job_bytes", usage.value().job_bytes},
                          {"job_bytes_max", JobStore::kBodyBytesMax},
                          {"runs_max", places.runs_per_caller_max},
                          {"simulators_max", places.simulators_per_caller}};
  if (usage.value().samples_max > 0) out["samples_max"] = usage.value().samples_max;
  return JsonResponse(out);
}

}  // namespace faultlab::server
