#pragma once

#include "server/api/gate.h"
#include "server/auth/accounts.h"
#include "server/auth/audit_log.h"
#include "server/course/assignments.h"
#include "server/course/blind_trials.h"
#include "server/course/groups.h"
#include "server/course/trials.h"
#include "server/experiment/experiments.h"
#include "server/experiment/fault_set_access.h"
#include "server/fault_sets/fault_sets.h"

// Assignments of a course and the blind trials of its students.
namespace faultlab::server {

struct CourseApi {
  course::Assignments& assignments;
  course::Trials& trials;
  course::Groups& groups;
  course::BlindTrials& blind_trials;
  FaultSets& fault_sets;
  FaultSetAccess& fault_set_access;
  Experiments& experiments;
  Accounts& accounts;
  Benches& benches;
  AuditLog& audit;
  const Clock& clock;
};

std::vector<ApiRoute> RoutesOf(CourseApi& api);

/// The assignment, if the caller teaches, attends or runs its course; kOwn: teaches.
struct SeenAssignment {
  course::Assignment assignment;
  Ownership whose = Ownership::kForeign;
  bool member = false;  ///< teaches or attends
};
boost::json::object ToJson(CourseApi& api, const course::Group& group);
core::Result<SeenAssignment> AssignmentFor(CourseApi& api, const Principal& who, std::int64_t id);
/// That of the path's {id}, if the caller teaches its course.
core::Result<SeenAssignment> ManagedAssignment(CourseApi& api, const ApiRequest& request);

// assignments.cc
core::Result<HttpResponse> ListAssignments(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> CreateAssignment(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> PreviewAssignment(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetAssignment(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> ChangeAssignment(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> ExtendAssignment(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> EndExtension(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> DeleteAssignment(CourseApi& api, const ApiRequest& request);

// groups.cc
core::Result<HttpResponse> EnterGroup(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> LeaveGroup(CourseApi& api, const ApiRequest& request);

// trials.cc
core::Result<HttpResponse> ListTrials(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> StartTrial(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetTrial(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> AnswerTrial(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> AwardPoints(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> TakeAwardBack(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> GetStatistics(CourseApi& api, const ApiRequest& request);
core::Result<HttpResponse> ExportGrades(CourseApi& api, const ApiRequest& request);

}  // namespace faultlab::server
