#include "core/control/tolerant_drive.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/filter/rig_parameters.h"
#include "core/isolation/fit_context.h"

namespace faultlab::core {
namespace {

// Closed loop against plant: 1.9 times as slow keeps the drive inside its range for usual steps.
constexpr double kFaster = 0.54;
// One controller for every fault of the bench: slower, so that a hundredfold inertia swings less.
constexpr double kRobustFaster = 0.35;
// A value is known when its standard error is below this share of it.
constexpr double kSureShare = 0.2;
// Of the currents that the motor stands, for what the model of it lacks.
constexpr double kPeakShare = 0.9;
constexpr double kContinuousShare = 0.95;

SpeedController ControllerOf(const SpeedModel& plant, double period_s, ControlKind kind) {
  return {plant, period_s, kind == ControlKind::kRobust ? kRobustFaster : kFaster};
}

}  // namespace

TolerantDrive::TolerantDrive(const Bench& bench,
                             const Calibration& calibration,
                             double period_s,
                             const ToleranceOptions& options,
                             double input_v)
    : bench_(bench),
      rig_(ParametersOf(calibration)),
      period_s_(period_s),
      options_(options),
      healthy_(SpeedModelOf(rig_, period_s)),
      known_(healthy_),
      known_rig_(rig_),
      controller_(ControllerOf(healthy_, period_s, options.kind)),
      actuator_(healthy_),
      noise_rad_s_(NoiseOf(calibration).w_rad_s),
      last_u_(std::clamp(input_v, bench.limits.uc_v_min, bench.limits.uc_v_max)),
      before_last_u_(last_u_),
      given_v_(last_u_) {
  controller_.Applied(last_u_);
}

double TolerantDrive::LargestInput() const {
  const double output_v = std::min(rig_.plant.range.output_max_v, bench_.limits.voltage_v_max);
  return std::min(bench_.limits.uc_v_max, output_v / known_rig_.gain());
}

double TolerantDrive::SustainedSpeed() const {
  const PlantParameters& motor = known_rig_.plant;
  const double torque_nm =
      kContinuousShare * bench_.limits.current_continuous_a * motor.kt_nm_per_a - known_rig_.mc_nm;
  return std::max(0.0, torque_nm / motor.b_nm_per_rad_s);
}

double TolerantDrive::reachable_rad_s() const {
  return std::clamp(known_.Settled(LargestInput()), 0.0, SustainedSpeed());
}

double TolerantDrive::Limited(double u) const {
  const PlantParameters& motor = known_rig_.plant;
  const double peak_v =
      kPeakShare * bench_.limits.current_peak_a * (motor.ra_ohm + motor.series_ohm);
  const double back_v = motor.ke_v_per_rad_s * speed_rad_s_;
  const double cool =
      std::clamp(u, (back_v - peak_v) / known_rig_.gain(), (back_v + peak_v) / known_rig_.gain());
  const double step = bench_.limits.slew_v_per_s * period_s_;
  const double slewed = std::clamp(cool, last_u_ - step, last_u_ + step);
  return std::clamp(slewed, bench_.limits.uc_v_min, bench_.limits.uc_v_max);
}

double TolerantDrive::Tick(double reference_rad_s, double speed_rad_s) {
  if (std::isfinite(speed_rad_s)) speed_rad_s_ = speed_rad_s;
  // From the reading before to this one; the edge is delta before a reading.
  const double late = std::clamp(rig_.delta_s / period_s_, 0.0, 1.0);
  const double mean_u_v = (1.0 - late) * before_last_u_ + late * last_u_;
  if (check_ && check_->Push(speed_rad_s, mean_u_v)) {
    refuted_ = believed_;
    Believe(std::nullopt);
  }
  const double v = controller_.Step(std::min(reference_rad_s, SustainedSpeed()), speed_rad_s_);
  const double wanted = actuator_.RigInput(v, speed_rad_s_);
  given_v_ = Limited(std::min(wanted, LargestInput()));
  if (given_v_ != wanted) controller_.Applied(actuator_.ControllerInput(given_v_, speed_rad_s_));
  // Two ticks up, two down: its mean is zero, and the controller does not answer it at once.
  const double dither =
      dithering_ ? ((ticks_ / 2) % 2 == 0 ? options_.dither_v : -options_.dither_v) : 0.0;
  ++ticks_;
  before_last_u_ = std::exchange(last_u_, Limited(given_v_ + dither));
  return last_u_;
}

void TolerantDrive::Heard(const Verdict& verdict) {
  if (options_.kind != ControlKind::kCompensated) return;
  const bool named = verdict.kind == VerdictKind::kFault && !verdict.candidates.empty();
  const bool alarmed =
      verdict.kind == VerdictKind::kFault || verdict.kind == VerdictKind::kUnknownFault;
  std::optional<Candidate> sure;
  if (named) {
    const Candidate& best = verdict.candidates.front();
    const bool known = best.bound == 0 && best.sigma < kSureShare * best.value;
    if ((known || verdict.settled) && !Refuted(best)) sure = best;
  }
  Believe(sure);
  dithering_ = alarmed && !compensates() && !(named && gave_up());
}

bool TolerantDrive::Refuted(const Candidate& fault) const {
  return refuted_ && refuted_->component == fault.component &&
         std::abs(fault.value - refuted_->value) < kSureShare * refuted_->value;
}

void TolerantDrive::Believe(const std::optional<Candidate>& fault) {
  std::optional<SpeedModel> faulty;
  known_rig_ = fault ? WithComponent(rig_, fault->component, fault->value) : rig_;
  if (fault) faulty = SpeedModelOf(known_rig_, period_s_);
  believed_ = fault;
  check_.reset();
  if (faulty) {
    const double lag_periods =
        known_rig_.lag_factor * known_rig_.plant.response().lag_s / period_s_;
    const double share = std::clamp(-std::log(faulty->kept) * lag_periods, 0.0, 1.0);
    check_.emplace(healthy_, *faulty, speed_rad_s_, noise_rad_s_, share);
  }
  // Bumpless: the controller goes on from the input that the rig has now.
  actuator_.Reconfigure(faulty);
  known_ = faulty.value_or(healthy_);
  controller_.Applied(actuator_.ControllerInput(given_v_, speed_rad_s_));
}

}  // namespace faultlab::core
