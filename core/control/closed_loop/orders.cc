#include "core/control/closed_loop/orders.h"

#include <algorithm>
#include <cmath>

#include "core/filter/speed_response.h"
#include "core/isolation/fit_context.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

// A value is known when its standard error is below this share of it.
constexpr double kSureShare = 0.2;
// Of the current that the motor stands for ever, for what the model of it lacks.
constexpr double kContinuousShare = 0.95;

/// @param output_max_v  that the amplifier gives at most: a fault does not change its supply
DriveModel ModelOf(const Bench& bench,
                   const RigParameters& rig,
                   double output_max_v,
                   double period_s) {
  const PlantParameters& motor = rig.plant;
  DriveModel model;
  model.speed = SpeedModelOf(rig, period_s);
  model.gain = rig.gain();
  model.resistance_ohm = motor.ra_ohm + motor.series_ohm;
  model.ke_v_per_rad_s = motor.ke_v_per_rad_s;
  model.input_max_v = bench.limits.uc_v_max;
  const double torque_nm =
      kContinuousShare * bench.limits.current_continuous_a * motor.kt_nm_per_a - rig.mc_nm;
  model.sustained_rad_s = std::max(0.0, torque_nm / motor.b_nm_per_rad_s);
  const double supply_v = std::min(output_max_v, bench.limits.voltage_v_max);
  if (motor.structure->drives_current()) {
    // Where the supply is used up by the turning motor and the current of its friction.
    const double ohm_per_nm = motor.ra_ohm / motor.kt_nm_per_a;
    model.sustained_rad_s =
        std::clamp((supply_v - ohm_per_nm * rig.mc_nm) /
                       (motor.ke_v_per_rad_s + ohm_per_nm * motor.b_nm_per_rad_s),
                   0.0,
                   model.sustained_rad_s);
  } else {
    model.input_max_v = std::min(model.input_max_v, supply_v / model.gain);
  }
  const double lag_periods = rig.lag_factor * motor.response().lag_s / period_s;
  const double periods = -1.0 / std::log(model.speed.kept);  // of the time constant
  model.motor_kept = lag_periods < periods ? std::exp(-1.0 / (periods - lag_periods)) : 0.0;
  model.direct = std::clamp(motor.response().direct, 0.0, 1.0);
  model.lag_kept = lag_periods > 0.0 ? std::exp(-1.0 / lag_periods) : 0.0;
  return model;
}

}  // namespace

SpeedModel SpeedModelOf(const RigParameters& rig, double period_s) {
  LAB_CHECK(period_s > 0.0, period_s);
  const SpeedNumbers numbers = SpeedNumbersOf(rig);
  return {.kept = std::exp(-period_s / numbers.time_constant_s),
          .gain = numbers.gain,
          .friction = numbers.friction};
}

DriveModel DescribedDrive(const Bench& bench, double period_s) {
  RigParameters rig;
  rig.plant = bench.nominal;
  rig.delta_s = bench.delta_s;
  rig.mc_nm = bench.norm.mc_nm;
  return ModelOf(bench, rig, bench.nominal.range.output_max_v, period_s);
}

ControlOrder OrderOf(const Bench& bench,
                     const Calibration& calibration,
                     const Verdict& verdict,
                     double period_s) {
  LAB_CHECK(period_s > 0.0, period_s);
  const RigParameters rig = ParametersOf(calibration);
  const double output_max_v = rig.plant.range.output_max_v;
  ControlOrder order;
  order.healthy = ModelOf(bench, rig, output_max_v, period_s);
  order.noise_rad_s = NoiseOf(calibration).w_rad_s;
  order.delta_s = rig.delta_s;
  order.alarmed = verdict.kind == VerdictKind::kFault || verdict.kind == VerdictKind::kUnknownFault;
  const bool alone = !verdict.sensor && !verdict.friction;
  order.named = verdict.kind == VerdictKind::kFault && !verdict.candidates.empty() && alone;
  if (!order.named) return order;
  const Candidate& best = verdict.candidates.front();
  const bool known = best.bound == 0 && best.sigma < kSureShare * best.value;
  if (!known && !verdict.settled) return order;
  const RigParameters faulty = WithComponent(rig, best.component, best.value);
  order.believed = {best.component, best.value, ModelOf(bench, faulty, output_max_v, period_s)};
  return order;
}

}  // namespace faultlab::core
