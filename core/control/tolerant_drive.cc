#include "core/control/tolerant_drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace faultlab::core {
namespace {

// The first input of a step to the highest speed, of the highest input: inside the range for usual
// steps. On a rig that its range alone limits the closed loop is 1.9 times as slow as the plant.
constexpr double kFaster = 0.54;
// One controller for every fault of the bench: slower, so that a hundredfold inertia swings less.
constexpr double kRobustFaster = 0.35;
// Two values of a part are about the same.
constexpr double kSameShare = 0.2;
// Of the peak current that the motor stands, for what the model of it lacks.
constexpr double kPeakShare = 0.9;

SpeedController ControllerOf(const DriveModel& rig, double period_s, ControlKind kind) {
  const double faster = kind == ControlKind::kRobust ? kRobustFaster : kFaster;
  const double highest_v = rig.speed.InputFor(rig.reachable_rad_s(), rig.reachable_rad_s());
  const double spare = highest_v > 0.0 ? std::max(1.0, rig.input_max_v / highest_v) : 1.0;
  return {rig.speed, period_s, faster * spare};
}

LaggedModel LaggedOf(const DriveModel& model) {
  SpeedModel motor = model.speed;
  motor.kept = model.motor_kept;
  return {motor, model.lag_kept, model.direct};
}

}  // namespace

std::string_view Name(ControlKind kind) {
  switch (kind) {
    case ControlKind::kNominal:
      return "nominal";
    case ControlKind::kCompensated:
      return "compensated";
    case ControlKind::kRobust:
      return "robust";
  }
  return "compensated";
}

std::optional<ControlKind> ParseControlKind(std::string_view name) {
  using enum ControlKind;
  for (const ControlKind kind : {kNominal, kCompensated, kRobust}) {
    if (Name(kind) == name) return kind;
  }
  return std::nullopt;
}

TolerantDrive::TolerantDrive(const BenchLimits& limits,
                             const ControlOrder& order,
                             double period_s,
                             const ToleranceOptions& options,
                             double input_v)
    : limits_(limits),
      healthy_(order.healthy),
      noise_rad_s_(order.noise_rad_s),
      late_(std::clamp(order.delta_s / period_s, 0.0, 1.0)),
      period_s_(period_s),
      options_(options),
      controller_(ControllerOf(healthy_, period_s, options.kind)),
      actuator_(healthy_.speed),
      last_u_(std::clamp(input_v, limits.uc_v_min, limits.uc_v_max)),
      before_last_u_(last_u_),
      given_v_(last_u_) {
  controller_.Applied(last_u_);
}

double TolerantDrive::Limited(double u) const {
  if (!std::isfinite(u)) u = last_u_;  // of an order that is no rig's
  const DriveModel& rig = known();
  const double peak_v = kPeakShare * limits_.current_peak_a * rig.resistance_ohm;
  const double back_v = rig.ke_v_per_rad_s * speed_rad_s_;
  const double cool = std::clamp(u, (back_v - peak_v) / rig.gain, (back_v + peak_v) / rig.gain);
  const double step = limits_.slew_v_per_s * period_s_;
  const double slewed = std::clamp(cool, last_u_ - step, last_u_ + step);
  return std::clamp(slewed, limits_.uc_v_min, limits_.uc_v_max);
}

double TolerantDrive::Tick(double reference_rad_s, double speed_rad_s) {
  if (std::isfinite(speed_rad_s)) speed_rad_s_ = speed_rad_s;
  // From the reading before to this one; the edge is delta before a reading.
  const double mean_u_v = (1.0 - late_) * before_last_u_ + late_ * last_u_;
  if (check_ && check_->Push(speed_rad_s, mean_u_v)) {
    refuted_ = believed_;
    Believe(std::nullopt);
  }
  if (alarmed_) Remember(speed_rad_s, mean_u_v);
  const double v =
      controller_.Step(std::min(reference_rad_s, known().sustained_rad_s), speed_rad_s_);
  const double wanted = actuator_.RigInput(v, speed_rad_s_, LagV());
  given_v_ = Limited(std::min(wanted, known().input_max_v));
  if (given_v_ != wanted)
    controller_.Applied(actuator_.ControllerInput(given_v_, speed_rad_s_, LagV()));
  // Two ticks up, two down: its mean is zero, and the controller does not answer it at once.
  const double dither =
      dithering_ ? ((ticks_ / 2) % 2 == 0 ? options_.dither_v : -options_.dither_v) : 0.0;
  ++ticks_;
  before_last_u_ = std::exchange(last_u_, Limited(given_v_ + dither));
  return last_u_;
}

void TolerantDrive::Heard(const ControlOrder& order) {
  if (options_.kind != ControlKind::kCompensated) return;
  if (!order.alarmed) read_ = 0;
  alarmed_ = order.alarmed;
  Believe(order.believed && !Refuted(*order.believed) ? order.believed : std::nullopt);
  dithering_ = order.alarmed && !compensates() && !(order.named && gave_up());
}

void TolerantDrive::Remember(double speed_rad_s, double mean_u_v) {
  since_alarm_[read_++ % kTrialTicks] = {speed_rad_s, mean_u_v};
}

std::optional<CompensationCheck> TolerantDrive::Tried(const BelievedFault& fault) const {
  const std::size_t first = read_ > kTrialTicks ? read_ - kTrialTicks : 0;
  const Reading start =
      read_ > first ? since_alarm_[first % kTrialTicks] : Reading{speed_rad_s_, last_u_};
  CompensationCheck check(LaggedOf(healthy_),
                          LaggedOf(fault.rig),
                          std::isfinite(start.speed_rad_s) ? start.speed_rad_s : speed_rad_s_,
                          start.mean_u_v,
                          noise_rad_s_);
  for (std::size_t k = first + 1; k < read_; ++k) {
    const Reading& reading = since_alarm_[k % kTrialTicks];
    if (check.Push(reading.speed_rad_s, reading.mean_u_v)) return std::nullopt;
  }
  return check;
}

double TolerantDrive::LagV() const {
  return check_ ? check_->lag_v() : last_u_;
}

bool TolerantDrive::Refuted(const BelievedFault& fault) const {
  return refuted_ && refuted_->component == fault.component &&
         std::abs(fault.value - refuted_->value) < kSameShare * refuted_->value;
}

void TolerantDrive::Believe(const std::optional<BelievedFault>& fault) {
  check_.reset();
  believed_.reset();
  if (fault) {
    check_ = Tried(*fault);
    (check_ ? believed_ : refuted_) = fault;
  }
  // Bumpless: the controller goes on from the input that the rig has now.
  if (believed_) {
    actuator_.Reconfigure(LaggedOf(believed_->rig));
  } else {
    actuator_.Withdraw();
  }
  controller_.Applied(actuator_.ControllerInput(given_v_, speed_rad_s_, LagV()));
}

}  // namespace faultlab::core
