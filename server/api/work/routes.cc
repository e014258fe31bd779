#include "server/api/work/handlers.h"

namespace faultlab::server {

std::vector<ApiRoute> RoutesOf(WorkApi& api) {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  using enum Cost;
  using enum LivesAt;
  const auto on = [&api](auto handler) { return On(api, handler); };
  return {
      {kGet, "/api/v1/jobs", kSubmitJob, kRole, on(ListJobs)},
      {kPost, "/api/v1/jobs", kSubmitJob, kRole, on(CreateJobs), kJobBatch, kQuick, kBodysRig},
      {kGet, "/api/v1/jobs/{id}", kSubmitJob, kRole, on(GetJob)},
      {kDelete, "/api/v1/jobs/{id}", kSubmitJob, kRole, on(CancelJob)},
      {kGet,
       "/api/v1/jobs/batches/{id}/sweep.png",
       kSubmitJob,
       kRole,
       on(GetSweepPlot),
       kNoBody,
       kHeavy},
      {kGet, "/api/v1/fault-sets", kReadFaultSet, kRole, on(ListFaultSets)},
      {kPost, "/api/v1/fault-sets", kManageFaultSet, kRole, on(CreateFaultSet), kJsonOnce},
      {kPut, "/api/v1/fault-sets/{id}", kManageFaultSet, kRole, on(ChangeFaultSet), kJson},
      {kDelete, "/api/v1/fault-sets/{id}", kManageFaultSet, kRole, on(DeleteFaultSet)},
      {kGet,
       "/api/v1/fault-sets/{id}/isolability",
       kReadFaultSet,
       kRole,
       on(GetIsolability),
       kNoBody,
       kHeavy},
      {kGet,
       "/api/v1/fault-sets/{id}/isolability.png",
       kReadFaultSet,
       kRole,
       on(GetIsolabilityPlot),
       kNoBody,
       kHeavy},
  };
}

}  // namespace faultlab::server
