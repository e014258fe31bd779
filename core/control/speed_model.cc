#include "core/control/speed_model.h"

#include <cmath>

#include "core/filter/speed_response.h"
#include "core/types/check.h"

namespace faultlab::core {

SpeedModel SpeedModelOf(const RigParameters& rig, double period_s) {
  LAB_CHECK(period_s > 0.0, period_s);
  const SpeedNumbers numbers = SpeedNumbersOf(rig);
  return {.kept = std::exp(-period_s / numbers.time_constant_s),
          .gain = numbers.gain,
          .friction = numbers.friction};
}

}  // namespace faultlab::core
