#pragma once

#include <boost/json/object.hpp>
#include <span>
#include <vector>

#include "core/isolability/isolability.h"
#include "server/course/fault_pool.h"
#include "server/course/grade.h"

namespace faultlab::server::course {

/// What an exercise gives to somebody who reads a record as well as its noise allows: how hard it
/// is, and how unlike for two students.
struct ExpectedGrade {
  double points = 0.0;  ///< mean over the draws, 0 .. 100
  double spread = 0.0;  ///< standard deviation between draws, of these means
  LikelyDraw hardest;   ///< the draw that gives the fewest
  double hardest_points = 0.0;
};

/// @param draws   LikelyDraws of the pool
/// @param judged  of each draw with a fault, in order
/// - A draw is told from the healthy rig, and from another component that the grade does not take
///   for it, with the error probability of the best test between two records, Phi(-sqrt(2 D) / 2).
/// - A value that is found gets its points: the grade allows for the bound of the record. One that
/// a
///   record bounds on one side only counts as found, too.
/// - A drift and an intermittent fault are judged as abrupt ones that stay.
/// - The stated confidence is the probability of being right.
ExpectedGrade ExpectGrade(const Rubric& rubric,
                          std::span<const LikelyDraw> draws,
                          std::span<const core::FaultIsolability> judged,
                          double kl_separable_nats);
/// {"points", "spread", "hardest": {"component": null of a healthy rig, "value", "points"}}
boost::json::object ToJson(const ExpectedGrade& expected);

}  // namespace faultlab::server::course
