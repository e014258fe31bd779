#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "server/experiment/experiment_plan.h"

// The speed control of a plan, as JSON.
namespace faultlab::server {

/// What a plan leaves out: two speeds that the bench reaches with most of its faults, in steps.
core::SpeedReference UsualReference(const core::Bench& bench);

/// Refuses by JSON pointer: "/control/reference/hold_s".
core::Result<WantedControl> ParseControl(const boost::json::object& object,
                                         const core::Bench& bench,
                                         double period_s);
boost::json::object ToJson(const WantedControl& control);

/// Of a stored plan.
struct PlannedControl {
  WantedControl wanted;
  double from_s = 0.0;  ///< the reference begins
  /// BenchProfile of the simulator that played it; empty: a rig that is none.
  std::string profile;
};
/// Nothing of a plan without speed control.
std::optional<PlannedControl> ControlOfPlan(std::string_view plan_json,
                                            const core::Bench& bench,
                                            double period_s);

/// The corners of a planned reference, from its beginning to the end of the plan.
struct ReferenceCorners {
  std::vector<double> t_s;
  std::vector<double> n_rpm;  ///< in the unit of n: behind the gear
};
ReferenceCorners CornersOf(const PlannedControl& planned,
                           const core::Bench& bench,
                           double period_s,
                           double duration_s);

/// For who plans: {"reachable_rad_s", "low_rad_s", "high_rad_s", "hold_s"}; null of a bench that
/// does not measure its speed.
boost::json::value ControlOf(const core::Bench& bench);

}  // namespace faultlab::server
