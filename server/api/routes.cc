#include "server/api/routes.h"

namespace faultlab::server {

// The table at the end of each handler file: that of notify/webhooks.cc is WebhooksRoutes().
std::span<const ApiRoute> AlarmsRoutes();
std::span<const ApiRoute> AssignmentsRoutes();
std::span<const ApiRoute> BenchesRoutes();
std::span<const ApiRoute> CalendarRoutes();
std::span<const ApiRoute> ComparisonRoutes();
std::span<const ApiRoute> ControlRoutes();
std::span<const ApiRoute> CoursesRoutes();
std::span<const ApiRoute> DataRoutes();
std::span<const ApiRoute> DemonstrationsRoutes();
std::span<const ApiRoute> ExportsRoutes();
std::span<const ApiRoute> FaultSetsRoutes();
std::span<const ApiRoute> FiguresRoutes();
std::span<const ApiRoute> GroupsRoutes();
std::span<const ApiRoute> HistoryRoutes();
std::span<const ApiRoute> HoursRoutes();
std::span<const ApiRoute> IsolabilityRoutes();
std::span<const ApiRoute> JobsRoutes();
std::span<const ApiRoute> LtiRoutes();
std::span<const ApiRoute> OutlookRoutes();
std::span<const ApiRoute> PeopleRoutes();
std::span<const ApiRoute> PersonFeedRoutes();
std::span<const ApiRoute> PicturesRoutes();
std::span<const ApiRoute> PlatformsRoutes();
std::span<const ApiRoute> PolicyRoutes();
std::span<const ApiRoute> ProvidersRoutes();
std::span<const ApiRoute> QueueRoutes();
std::span<const ApiRoute> ReportRoutes();
std::span<const ApiRoute> ReportsRoutes();
std::span<const ApiRoute> RigsRoutes();
std::span<const ApiRoute> RostersRoutes();
std::span<const ApiRoute> RunsRoutes();
std::span<const ApiRoute> SessionsRoutes();
std::span<const ApiRoute> SignInRoutes();
std::span<const ApiRoute> SweepRoutes();
std::span<const ApiRoute> SystemRoutes();
std::span<const ApiRoute> TrialsRoutes();
std::span<const ApiRoute> UploadsRoutes();
std::span<const ApiRoute> UsageRoutes();
std::span<const ApiRoute> WebhooksRoutes();

std::span<const ApiTable> ApiTables() {
  static constexpr auto kTables = std::to_array<ApiTable>(
      {AlarmsRoutes,         AssignmentsRoutes, BenchesRoutes,   CalendarRoutes,
       ComparisonRoutes,     ControlRoutes,     CoursesRoutes,   DataRoutes,
       DemonstrationsRoutes, ExportsRoutes,     FaultSetsRoutes, FiguresRoutes,
       GroupsRoutes,         HistoryRoutes,     HoursRoutes,     IsolabilityRoutes,
       JobsRoutes,           LtiRoutes,         OutlookRoutes,   PeopleRoutes,
       PersonFeedRoutes,     PicturesRoutes,    PlatformsRoutes, PolicyRoutes,
       ProvidersRoutes,      QueueRoutes,       ReportRoutes,    ReportsRoutes,
       RigsRoutes,           RostersRoutes,     RunsRoutes,      SessionsRoutes,
       SignInRoutes,         SweepRoutes,       SystemRoutes,    TrialsRoutes,
       UploadsRoutes,        UsageRoutes,       WebhooksRoutes});
  return kTables;
}

void AddRoutes(Gate& gate, Router& router) {
  for (const ApiTable table : ApiTables()) gate.AddRoutes(router, table());
}

}  // namespace faultlab::server
