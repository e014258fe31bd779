#include "server/run/loop_json.h"

#include <boost/json.hpp>
#include <cmath>

#include "server/json/list_of.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

/// Whole microseconds; measurements are not finer.
std::int64_t Microseconds(double time_s) {
  return std::llround(time_s * 1e6);
}

}  // namespace

json::object ToJson(const hardware::LoopQuality& loop) {
  constexpr double kUsPerMs = 1e3;
  return {
      {"ticks", loop.lateness.count()},
      {"p50_us", Microseconds(loop.lateness.QuantileBound(0.5))},
      {"p99_us", Microseconds(loop.lateness.QuantileBound(0.99))},
      {"worst_us", Microseconds(loop.lateness.worst_s)},
      {"overruns", loop.overruns},
      {"missed_ticks", loop.missed_ticks},
      {"fifo", loop.fifo},
      {"lateness",
       json::object{{"le_us", ListOf(hardware::TimeHistogram::kBoundsUs)},
                    {"counts", ListOf(loop.lateness.counts)}}},
      {"commands", loop.actuation.count()},
      {"command_p50_ms",
       static_cast<double>(Microseconds(loop.actuation.QuantileBound(0.5))) / kUsPerMs},
      {"command_worst_ms", static_cast<double>(Microseconds(loop.actuation.worst_s)) / kUsPerMs}};
}

}  // namespace faultlab::server
