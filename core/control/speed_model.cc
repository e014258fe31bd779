#include "core/control/speed_model.h"

#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {

SpeedModel SpeedModelOf(const RigParameters& rig, double period_s) {
  LAB_CHECK(period_s > 0.0, period_s);
  const PlantParameters& p = rig.plant;
  const double r = p.ra_ohm + p.series_ohm;
  const double d = p.b_nm_per_rad_s * r + p.ke_v_per_rad_s * p.kt_nm_per_a;
  const double time_constant_s = p.j_kg_m2 * r / d + rig.lag_factor * p.response().lag_s;
  return {.kept = std::exp(-period_s / time_constant_s),
          .gain = rig.gain() * p.kt_nm_per_a / d,
          .friction = r * rig.mc_nm / d};
}

}  // namespace faultlab::core
