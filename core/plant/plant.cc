#include "core/plant/plant.h"

#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr double kSubStepS = 1e-4;     // the Stribeck torque is held constant no longer than this
constexpr double kNoiseHoldS = 0.01;   // friction noise is held constant no longer than this
constexpr double kStribeckLog = 30.0;  // exp(-30) of Ms - Mc is under 1e-17 Nm
// An event is located to 2^-18 of a sub-step, 0.4 ns.
constexpr int kBisections = 18;
constexpr int kEventsPerStepMax = 16;

int Sign(double value) {
  return (value > 0.0) - (value < 0.0);
}

}  // namespace

Plant::Plant(const PlantParameters& parameters, const BenchProfile& profile, std::uint64_t seed)
    : parameters_(parameters),
      friction_(profile.friction),
      amplifier_(profile.amplifier),
      random_(seed) {
  LAB_CHECK(parameters.structure != nullptr && parameters.series_ohm >= 0.0);
  for (int i = kSeries + 1; i < parameters.structure->parameter_count(); ++i) {
    LAB_CHECK(parameters.Get(i) > 0.0, i);
  }
  LAB_CHECK(friction_.stribeck_shape >= 0 && friction_.stribeck_shape <= 2);
  LAB_CHECK(friction_.stribeck_speed_rad_s > 0.0 && friction_.noise_tau_s > 0.0);
  LAB_CHECK(amplifier_.output_max_v > 0.0);
  SetFriction(friction_.mc_nm, friction_.ms_nm);
  if (drives_current()) parameters_.series_ohm = 0.0;  // of the models alone
  ParametersChanged();
  friction_noise_nm_ =
      friction_.noise_rms_nm > 0.0 ? friction_.noise_rms_nm * random_.Normal() : 0.0;
}

void Plant::SetInput(double uc_v) {
  LAB_CHECK(std::isfinite(uc_v), uc_v);
  uc_v_ = uc_v;
}

void Plant::Set(Component component, double value) {
  if (parameters_.Get(component) == value) {
    return;
  }
  parameters_.Set(component, value);
  if (component.info().kind == PartKind::kCapacitor) {
    x_(0) = 0.0;
  }
  ParametersChanged();
}

void Plant::Drift(Component component, double value) {
  const double before = parameters_.Get(component);
  if (before == value) {
    return;
  }
  parameters_.Set(component, value);
  if (component.info().kind == PartKind::kCapacitor) {
    x_(0) *= before / value;
  }
  ParametersChanged();
}

void Plant::ParametersChanged() {
  propagators_.Reset(parameters_, amplifier_.gain_error);
  const AmplifierResponse response = parameters_.response();
  output_per_uc_ = response.gain * response.direct * (1.0 + amplifier_.gain_error);
  output_per_v_ = 1.0 - response.direct;
}

void Plant::SetFriction(double mc_nm, double ms_nm) {
  LAB_CHECK(mc_nm >= 0.0 && ms_nm >= mc_nm, mc_nm, ms_nm);
  friction_.mc_nm = mc_nm;
  friction_.ms_nm = ms_nm;
  const double widths = friction_.stribeck_shape == 1 ? kStribeckLog : std::sqrt(kStribeckLog);
  const bool acts = ms_nm > mc_nm && friction_.stribeck_shape != 0;
  stribeck_speed_max_rad_s_ = acts ? widths * friction_.stribeck_speed_rad_s : 0.0;
}

void Plant::SetState(const Eigen::Vector3d& state) {
  LAB_CHECK(state.allFinite());
  x_ = state;
  direction_ = Sign(state(2));
}

PlantOutputs Plant::outputs() const {
  PlantOutputs out;
  out.uc_v = uc_v_;
  out.ua_v = std::clamp(Output(x_), low_limit_v(), high_limit_v());
  out.ia_a = x_(1);
  out.um_v = out.ua_v - parameters_.series_ohm * out.ia_a;
  out.omega_rad_s = x_(2);
  out.angle_rad = angle_rad_;
  return out;
}

double Plant::low_limit_v() const {
  return amplifier_.quadrants == Quadrants::kTwo ? 0.0 : -amplifier_.output_max_v;
}

double Plant::current_reference_a() const {
  return parameters_.amplifier[0] * (1.0 + amplifier_.gain_error) * uc_v_;
}

LinearRegime Plant::regime() const {
  LinearRegime regime;
  regime.turning = direction_ != 0;
  if (amplifier_state_ != AmplifierState::kLinear) {
    regime.output = LinearRegime::Output::kClamped;
  } else {
    regime.output =
        drives_current() ? LinearRegime::Output::kCurrent : LinearRegime::Output::kAmplifier;
  }
  return regime;
}

double Plant::drive() const {
  switch (amplifier_state_) {
    case AmplifierState::kClampedHigh:
      return high_limit_v();
    case AmplifierState::kClampedLow:
      return low_limit_v();
    case AmplifierState::kLinear:
      break;
  }
  return drives_current() ? current_reference_a() : uc_v_;
}

double Plant::WantedOutput(const Eigen::Vector3d& x) const {
  if (drives_current()) {
    return (parameters_.series_ohm + parameters_.ra_ohm) * x(1) + parameters_.ke_v_per_rad_s * x(2);
  }
  return output_per_uc_ * uc_v_ + output_per_v_ * x(0);
}

double Plant::Output(const Eigen::Vector3d& x) const {
  return amplifier_state_ == AmplifierState::kLinear ? WantedOutput(x) : drive();
}

double Plant::FrictionTorque(double omega_rad_s) const {
  const double speed = std::abs(omega_rad_s);
  double torque = friction_.mc_nm + friction_noise_nm_;
  if (speed < stribeck_speed_max_rad_s_) torque += friction_.StribeckTorque(speed);
  return std::max(torque, 0.0);
}

double Plant::BreakawayTorque() const {
  return std::max(friction_.ms_nm + friction_noise_nm_, 0.0);
}

bool Plant::StribeckActs(const Eigen::Vector3d& x) const {
  return direction_ != 0 && std::abs(x(2)) < stribeck_speed_max_rad_s_;
}

void Plant::UpdateFrictionNoise(double seconds) {
  if (friction_.noise_rms_nm > 0.0) {
    const double keep = std::exp(-seconds / friction_.noise_tau_s);
    friction_noise_nm_ = keep * friction_noise_nm_ +
                         friction_.noise_rms_nm * std::sqrt(1.0 - keep * keep) * random_.Normal();
  }
}

void Plant::ResolveAmplifier() {
  if (drives_current()) {
    const double missing_a = current_reference_a() - x_(1);
    if (amplifier_state_ == AmplifierState::kLinear && missing_a != 0.0) {
      // The reference has changed: the full voltage drives the current to it.
      amplifier_state_ =
          missing_a > 0.0 ? AmplifierState::kClampedHigh : AmplifierState::kClampedLow;
      return;
    }
    const bool arrived = (amplifier_state_ == AmplifierState::kClampedHigh && missing_a <= 0.0) ||
                         (amplifier_state_ == AmplifierState::kClampedLow && missing_a >= 0.0);
    if (amplifier_state_ != AmplifierState::kLinear && !arrived) {
      return;
    }
    x_(1) = current_reference_a();
  }
  const double wanted_v = WantedOutput(x_);
  if (wanted_v > high_limit_v()) {
    amplifier_state_ = AmplifierState::kClampedHigh;
  } else if (wanted_v < low_limit_v()) {
    amplifier_state_ = AmplifierState::kClampedLow;
  } else {
    amplifier_state_ = AmplifierState::kLinear;
  }
}

bool Plant::AmplifierLeaves(const Eigen::Vector3d& x) const {
  const double progress = drives_current() ? x(1) - current_reference_a() : 0.0;
  const double wanted_v = WantedOutput(x);
  switch (amplifier_state_) {
    case AmplifierState::kClampedHigh:
      return drives_current() ? progress > 0.0 : wanted_v < high_limit_v();
    case AmplifierState::kClampedLow:
      return drives_current() ? progress < 0.0 : wanted_v > low_limit_v();
    case AmplifierState::kLinear:
      break;
  }
  return wanted_v > high_limit_v() || wanted_v < low_limit_v();
}

bool Plant::MotionLeaves(const Eigen::Vector3d& x) const {
  const double drive_nm = parameters_.kt_nm_per_a * x(1);
  if (direction_ == 0) {
    return std::abs(drive_nm) > BreakawayTorque();
  }
  const double speed = direction_ * x(2);
  return speed < 0.0 ||
         (speed < friction_.standstill_speed_rad_s && direction_ * drive_nm < FrictionTorque(x(2)));
}

void Plant::ResolveMotion() {
  if (!MotionLeaves(x_)) {
    return;
  }
  const double drive_nm = parameters_.kt_nm_per_a * x_(1);
  x_(2) = 0.0;
  direction_ = std::abs(drive_nm) > BreakawayTorque() ? Sign(drive_nm) : 0;
}

Plant::Reached Plant::Apply(const Propagator& propagator,
                            const Eigen::Vector3d& x,
                            double torque_nm) const {
  const double u = drive();
  Reached reached;
  reached.x.noalias() = propagator.phi * x;
  reached.x += propagator.gamma_u * u + propagator.gamma_m * torque_nm;
  reached.angle_rad = angle_rad_ + propagator.angle_x.dot(x) + propagator.angle_u * u +
                      propagator.angle_m * torque_nm;
  return reached;
}

Plant::Reached Plant::StepTo(double step_s, bool remember) {
  const auto apply = [&](double seconds, double torque_nm) {
    if (remember) {
      return Apply(propagators_.Get(regime(), seconds), x_, torque_nm);
    }
    return Apply(propagators_.Once(regime(), seconds), x_, torque_nm);
  };
  double torque_nm = direction_ * FrictionTorque(x_(2));
  if (StribeckActs(x_)) {
    torque_nm = direction_ * FrictionTorque(apply(0.5 * step_s, torque_nm).x(2));
  }
  return apply(step_s, torque_nm);
}

void Plant::Accept(const Reached& reached) {
  x_ = reached.x;
  angle_rad_ = reached.angle_rad;
}

bool Plant::TryWholeStep(double seconds) {
  // The poles are real and the motor is well above standstill at both ends, so no event can lie
  // between. The output voltage is monotonic under a held input, so it suffices to test its limits
  // at both ends.
  if (propagators_.oscillates() || direction_ == 0 || drives_current() ||
      amplifier_state_ != AmplifierState::kLinear || StribeckActs(x_)) {
    return false;
  }
  const Reached reached =
      Apply(propagators_.Get(regime(), seconds), x_, direction_ * (FrictionTorque(x_(2))));
  if (direction_ * reached.x(2) <= stribeck_speed_max_rad_s_ || MotionLeaves(reached.x) ||
      AmplifierLeaves(reached.x)) {
    return false;
  }
  Accept(reached);
  return true;
}

void Plant::StepWithEvents(double step_s) {
  double left_s = step_s;
  bool whole = true;
  for (int events = 0; left_s > 0.0; ++events) {
    ResolveAmplifier();
    ResolveMotion();
    const Reached end = StepTo(left_s, whole);
    const bool leaves = AmplifierLeaves(end.x) || MotionLeaves(end.x);
    if (!leaves || events == kEventsPerStepMax) {
      Accept(end);
      return;
    }
    whole = false;
    double before_s = 0.0;
    double after_s = left_s;
    Reached event = end;
    for (int i = 0; i < kBisections; ++i) {
      const double middle_s = 0.5 * (before_s + after_s);
      const Reached middle = StepTo(middle_s, false);
      if (AmplifierLeaves(middle.x) || MotionLeaves(middle.x)) {
        after_s = middle_s;
        event = middle;
      } else {
        before_s = middle_s;
      }
    }
    Accept(event);
    left_s -= after_s;
  }
}

void Plant::Advance(double seconds) {
  LAB_CHECK(seconds >= 0.0 && seconds <= 1.0, seconds);
  if (seconds == 0.0) {
    return;
  }
  if (seconds > kNoiseHoldS && friction_.noise_rms_nm > 0.0) {
    const int parts = static_cast<int>(std::ceil(seconds / kNoiseHoldS));
    for (int i = 0; i < parts; ++i) {
      Advance(seconds / parts);
    }
    return;
  }
  UpdateFrictionNoise(seconds);
  ResolveAmplifier();
  ResolveMotion();
  if (TryWholeStep(seconds)) {
    return;
  }
  const int parts = static_cast<int>(std::ceil(seconds / kSubStepS * (1.0 - 1e-12)));
  const double step_s = seconds / parts;
  for (int i = 0; i < parts; ++i) {
    StepWithEvents(step_s);
  }
}

}  // namespace faultlab::core
