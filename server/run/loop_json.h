#pragma once

#include <boost/json/object.hpp>

#include "hardware/loop_quality.h"

namespace faultlab::server {

/// {"ticks","p50_us","p99_us","worst_us","overruns","missed_ticks","fifo","lateness":{"le_us":[..],
/// "counts":[..]},"commands","command_p50_ms","command_worst_ms"}. The last bucket of `counts` has
/// no bound in `le_us`; quantiles are bounds of their buckets.
boost::json::object ToJson(const hardware::LoopQuality& loop);

}  // namespace faultlab::server
