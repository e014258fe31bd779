#include "core/control/control_order.h"

#include <algorithm>
#include <cmath>

namespace faultlab::core {
namespace {

bool IsPossible(const DriveModel& model) {
  const SpeedModel& speed = model.speed;
  // A bench without a stated current has no sustained speed: infinity is one.
  return speed.kept > 0.0 && speed.kept < 1.0 && speed.gain > 0.0 && std::isfinite(speed.gain) &&
         std::isfinite(speed.friction) && model.gain > 0.0 && std::isfinite(model.gain) &&
         model.resistance_ohm > 0.0 && std::isfinite(model.resistance_ohm) &&
         std::isfinite(model.ke_v_per_rad_s) && std::isfinite(model.input_max_v) &&
         model.sustained_rad_s >= 0.0 && model.motor_kept >= 0.0 && model.motor_kept < 1.0 &&
         model.lag_kept >= 0.0 && model.lag_kept < 1.0 && model.direct >= 0.0 &&
         model.direct <= 1.0;
}

}  // namespace

double DriveModel::reachable_rad_s() const {
  return std::clamp(speed.Settled(input_max_v), 0.0, sustained_rad_s);
}

Status Validate(const ControlOrder& order) {
  const bool possible =
      IsPossible(order.healthy) && std::isfinite(order.noise_rad_s) && order.noise_rad_s >= 0.0 &&
      std::isfinite(order.delta_s) &&
      (!order.believed || (IsPossible(order.believed->rig) &&
                           std::isfinite(order.believed->value) && order.believed->value > 0.0));
  if (possible) return Done{};
  return Error{ErrorCode::kInvalid, "no rig is as this order has it", "control", "internal"};
}

}  // namespace faultlab::core
