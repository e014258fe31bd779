#include "server/api/course/handlers.h"

namespace faultlab::server {

std::vector<ApiRoute> RoutesOf(CourseApi& api) {
  using enum HttpMethod;
  using enum Operation;
  using enum Guard;
  using enum Cost;
  using enum LivesAt;
  const auto on = [&api](auto handler) { return On(api, handler); };
  // Whoever looks first at a class that is due releases all its trials: no quick work.
  return {
      {kGet, "/api/v1/assignments", kReadCourse, kRole, on(ListAssignments)},
      {kPost, "/api/v1/assignments", kManageCourse, kRole, on(CreateAssignment), kJsonOnce, kHeavy},
      {kPost,
       "/api/v1/assignments/preview",
       kManageCourse,
       kRole,
       on(PreviewAssignment),
       kJson,
       kHeavy},
      {kGet, "/api/v1/assignments/{id}", kReadCourse, kRole, on(GetAssignment)},
      {kPatch, "/api/v1/assignments/{id}", kManageCourse, kRole, on(ChangeAssignment), kJson},
      {kPost, "/api/v1/assignments/{id}/group", kReadCourse, kRole, on(EnterGroup), kJson},
      {kDelete, "/api/v1/assignments/{id}/group", kReadCourse, kRole, on(LeaveGroup)},
      {kPut,
       "/api/v1/assignments/{id}/extensions/{user}",
       kManageCourse,
       kRole,
       on(ExtendAssignment),
       kJson},
      {kDelete,
       "/api/v1/assignments/{id}/extensions/{user}",
       kManageCourse,
       kRole,
       on(EndExtension)},
      {kDelete, "/api/v1/assignments/{id}", kManageCourse, kRole, on(DeleteAssignment)},
      {kGet,
       "/api/v1/assignments/{id}/trials",
       kReadCourse,
       kRole,
       on(ListTrials),
       kNoBody,
       kHeavy},
      {kPost,
       "/api/v1/assignments/{id}/trials",
       kStartRun,
       kRole,
       on(StartTrial),
       kJsonOnce,
       kQuick,
       kBodysRig},
      {kGet,
       "/api/v1/assignments/{id}/grades.csv",
       kManageCourse,
       kRole,
       on(ExportGrades),
       kNoBody,
       kHeavy},
      {kGet,
       "/api/v1/assignments/{id}/statistics",
       kManageCourse,
       kRole,
       on(GetStatistics),
       kNoBody,
       kHeavy},
      {kPut, "/api/v1/trials/{id}/points", kManageCourse, kRole, on(AwardPoints), kJson},
      {kDelete, "/api/v1/trials/{id}/points", kManageCourse, kRole, on(TakeAwardBack)},
      {kGet, "/api/v1/trials/{id}", kReadCourse, kRole, on(GetTrial)},
      {kPost, "/api/v1/trials/{id}/answer", kStartRun, kRole, on(AnswerTrial), kJsonOnce, kHeavy},
  };
}

}  // namespace faultlab::server
