#pragma once

#include "core/control/control_order.h"
#include "hardware/rig.h"
#include "tests/hardware/rig_runs.h"

// A plan of speed control, and what a diagnosis might say.
namespace faultlab::hardware {

inline constexpr std::int64_t kControlFrom = 100;
inline constexpr int kControlledSamples = 1000;

/// About the paper's bench; `gain` is of its speed, rad/s per volt.
inline core::ControlOrder Order(double gain = 95.0) {
  core::ControlOrder order;
  order.healthy.speed = {.kept = 0.87, .gain = gain, .friction = 20.0};
  order.healthy.gain = 2.4;
  order.healthy.resistance_ohm = 8.4;
  order.healthy.ke_v_per_rad_s = 0.0245;
  order.healthy.input_max_v = 5.0;
  order.healthy.sustained_rad_s = 1000.0;
  order.healthy.motor_kept = order.healthy.speed.kept;
  order.noise_rad_s = 0.5;
  order.delta_s = 0.0095;
  return order;
}

inline RigCommand Ordered(const core::ControlOrder& order) {
  RigCommand command{.kind = RigCommand::Kind::kControl};
  command.control = order;
  return command;
}

inline RunPlan ControlledPlan() {
  RunPlan plan = SquarePlan(kControlledSamples);
  plan.control =
      SpeedControlPlan{.reference = {.low_rad_s = 150.0, .high_rad_s = 170.0, .hold_s = 2.0},
                       .options = {},
                       .from = kControlFrom};
  return plan;
}

}  // namespace faultlab::hardware
