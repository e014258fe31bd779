#pragma once

#include <boost/json/object.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "server/api/metrics_text.h"
#include "server/run/rig_pool.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// An operator sees what tripped a rig and how its commands went. To everybody else the numbers and
/// their times could tell the faults of a hidden run.
enum class RigReader { kAnybody, kOperator };

/// A rig as GET /api/v1/rigs shows it: what it can do, how it is, what holds it. Its components and
/// their values are its bench's: bench_json.h.
boost::json::object RigToJson(const RigStatus& rig, WallTime now, RigReader who);

/// Whole days since the date that a calibration's text begins with ("2026-11-20 v1").
std::optional<int> CalibrationAgeDays(std::string_view calibration, WallTime now);

/// Per rig: lateness and command time as histograms, overruns, missed ticks, trip; of far rigs the
/// link. A rig that has never ticked has no histogram, one in use no command time: its count would
/// tell when a hidden fault is switched.
void AddRigMetrics(MetricsText& out, const std::vector<RigStatus>& rigs);

}  // namespace faultlab::server
