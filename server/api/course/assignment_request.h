#pragma once

#include <boost/json/object.hpp>

#include "core/isolability/isolability.h"
#include "server/api/course/handlers.h"
#include "server/course/expected_grade.h"
#include "server/json/json_reader.h"

// What a request says of an assignment. Errors name the field.
namespace faultlab::server {

/// Leaves `time` as it is where the member is absent.
core::Status ReadTime(ObjectReader& in, const char* name, WallTime& time);

/// What may change later: name, times, attempts, release. What is absent stays.
core::Status ReadTerms(ObjectReader& in, course::Assignment& assignment);

/// The due time lies after `earliest_due` and after the opening.
core::Status CheckTimes(const course::Assignment& assignment, WallTime earliest_due);

/// Bench, pool and plan of `assignment.fault_set`, if the caller may use the set and a trial can be
/// solved. `wanted`: the request's plan, or null.
core::Status TakeSet(Api& api,
                     const ApiRequest& request,
                     const boost::json::object* wanted,
                     course::Assignment& assignment);

struct JudgedPool {
  core::Isolability isolability;  ///< of each item the faults that are nearest to nominal
  course::ExpectedGrade expected;
};
/// Which faults of a pool can be seen in what is played, and told apart, and what that gives.
/// Refuses what TakeSet would refuse of its bench, pool and plan.
core::Result<JudgedPool> JudgePool(Api& api,
                                   const ApiRequest& request,
                                   const std::string& bench,
                                   const boost::json::object& pool,
                                   const boost::json::object* wanted,
                                   const course::Rubric& rubric);

}  // namespace faultlab::server
