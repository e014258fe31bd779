#pragma once

#include <boost/json/object.hpp>

#include "core/bench/bench.h"
#include "core/types/plant_parameters.h"

namespace faultlab::server {

/// A bench as GET /api/v1/benches shows it: its data sheet, its components in the order in which
/// they are shown, the values that can be set and the relay line that connects each, its channels,
/// the stretch in which a run learns its healthy rig, how long a run may be, and what was published
/// about its faults. What differs between the rigs of one bench is in RigToJson.
boost::json::object BenchToJson(const core::Bench& bench);

/// Parameters of the first-order model of these components: as SIA reads them {b0, b1, a1}, and as
/// SWA does {b0d, b1d, a1d}, um read `delta_s` after its input.
/// Contract: 0 <= delta_s <= period_s.
boost::json::object ModelToJson(const core::PlantParameters& plant,
                                double period_s,
                                double delta_s);

}  // namespace faultlab::server
