#include "hardware/lcm/control_codec.h"

namespace faultlab::hardware {
namespace {

faultlab_msgs::rig_drive_t Encoded(const core::DriveModel& model) {
  faultlab_msgs::rig_drive_t out;
  out.kept = model.speed.kept;
  out.speed_gain = model.speed.gain;
  out.friction = model.speed.friction;
  out.gain = model.gain;
  out.resistance_ohm = model.resistance_ohm;
  out.ke_v_per_rad_s = model.ke_v_per_rad_s;
  out.input_max_v = model.input_max_v;
  out.sustained_rad_s = model.sustained_rad_s;
  out.motor_kept = model.motor_kept;
  out.lag_kept = model.lag_kept;
  out.direct = model.direct;
  return out;
}

core::DriveModel Decoded(const faultlab_msgs::rig_drive_t& in) {
  return {.speed = {.kept = in.kept, .gain = in.speed_gain, .friction = in.friction},
          .gain = in.gain,
          .resistance_ohm = in.resistance_ohm,
          .ke_v_per_rad_s = in.ke_v_per_rad_s,
          .input_max_v = in.input_max_v,
          .sustained_rad_s = in.sustained_rad_s,
          .motor_kept = in.motor_kept,
          .lag_kept = in.lag_kept,
          .direct = in.direct};
}

}  // namespace

faultlab_msgs::rig_reference_t ToMessage(const SpeedControlPlan& plan) {
  faultlab_msgs::rig_reference_t out;
  out.shape = core::Name(plan.reference.shape);
  out.low_rad_s = plan.reference.low_rad_s;
  out.high_rad_s = plan.reference.high_rad_s;
  out.hold_s = plan.reference.hold_s;
  out.controller = core::Name(plan.options.kind);
  out.dither_v = plan.options.dither_v;
  out.from = plan.from;
  return out;
}

std::optional<SpeedControlPlan> FromMessage(const faultlab_msgs::rig_reference_t& in) {
  const auto shape = core::ParseReferenceShape(in.shape);
  const auto kind = core::ParseControlKind(in.controller);
  if (!shape || !kind) return std::nullopt;
  return SpeedControlPlan{.reference = {.shape = *shape,
                                        .low_rad_s = in.low_rad_s,
                                        .high_rad_s = in.high_rad_s,
                                        .hold_s = in.hold_s},
                          .options = {.kind = *kind, .dither_v = in.dither_v},
                          .from = in.from};
}

faultlab_msgs::rig_order_t ToMessage(const core::ControlOrder& order) {
  faultlab_msgs::rig_order_t out{};
  out.healthy = Encoded(order.healthy);
  out.noise_rad_s = order.noise_rad_s;
  out.delta_s = order.delta_s;
  out.alarmed = order.alarmed;
  out.named = order.named;
  if (!order.believed) return out;
  out.component = core::Name(order.believed->component);
  out.value = order.believed->value;
  out.faulty = Encoded(order.believed->rig);
  return out;
}

std::optional<core::ControlOrder> FromMessage(const faultlab_msgs::rig_order_t& in,
                                              const core::Bench& bench) {
  core::ControlOrder order{.healthy = Decoded(in.healthy),
                           .noise_rad_s = in.noise_rad_s,
                           .delta_s = in.delta_s,
                           .alarmed = in.alarmed != 0,
                           .named = in.named != 0};
  if (in.component.empty()) return order;
  const std::optional<core::Component> component = bench.Find(in.component);
  if (!component) return std::nullopt;
  order.believed = core::BelievedFault{*component, in.value, Decoded(in.faulty)};
  return order;
}

}  // namespace faultlab::hardware
