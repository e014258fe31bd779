#include "hardware/lcm/clock_offset.h"

namespace faultlab::hardware {
namespace {

constexpr double kNanosecond = 1e-9;
/// The quickest exchange tells the offset best; but clocks drift, so one nearly as quick replaces
/// it.
constexpr double kNearlyAsQuick = 1.5;

}  // namespace

void ClockOffset::Exchange(std::int64_t sent_ns,
                           std::int64_t received_ns,
                           std::int64_t replied_ns,
                           std::int64_t back_ns) {
  const double round_trip_s =
      static_cast<double>((back_ns - sent_ns) - (replied_ns - received_ns)) * kNanosecond;
  if (offset_s_ && round_trip_s > round_trip_s_ * kNearlyAsQuick) return;
  offset_s_ =
      static_cast<double>((received_ns - sent_ns) + (replied_ns - back_ns)) * 0.5 * kNanosecond;
  round_trip_s_ = round_trip_s;
}

}  // namespace faultlab::hardware
