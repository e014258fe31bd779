#pragma once

#include "server/api/api.h"

// Assignments of a course and the blind trials of its students.
namespace faultlab::server {

/// The assignment, if the caller teaches, attends or runs its course; kOwn: teaches.
struct SeenAssignment {
  course::Assignment assignment;
  Ownership whose = Ownership::kForeign;
  bool member() const { return whose != Ownership::kForeign; }  ///< teaches or attends
};
boost::json::object ToJson(Api& api, const course::Group& group);
core::Result<SeenAssignment> AssignmentFor(Api& api, const Principal& who, std::int64_t id);
/// That of the path's {id}, if the caller teaches its course.
core::Result<SeenAssignment> ManagedAssignment(Api& api, const ApiRequest& request);

}  // namespace faultlab::server
