#include "core/control/tolerant_drive.h"

#include <algorithm>
#include <cmath>

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
      output_per_input_(rig_.gain()),
      controller_(ControllerOf(healthy_, period_s, options.kind)),
      actuator_(healthy_),
      last_u_(std::clamp(input_v, bench.limits.uc_v_min, bench.limits.uc_v_max)),
      given_v_(last_u_) {
  controller_.Applied(last_u_);
}

double TolerantDrive::LargestInput() const {
  const double output_v = std::min(rig_.plant.range.output_max_v, bench_.limits.voltage_v_max);
  return std::min(bench_.limits.uc_v_max, output_v / output_per_input_);
}

double TolerantDrive::reachable_rad_s() const {
  return std::max(0.0, known_.Settled(LargestInput()));
}

double TolerantDrive::Limited(double u) const {
  const double step = bench_.limits.slew_v_per_s * period_s_;
  const double slewed = std::clamp(u, last_u_ - step, last_u_ + step);
  return std::clamp(slewed, bench_.limits.uc_v_min, bench_.limits.uc_v_max);
}

double TolerantDrive::Tick(double reference_rad_s, double speed_rad_s) {
  if (std::isfinite(speed_rad_s)) speed_rad_s_ = speed_rad_s;
  const double v = controller_.Step(reference_rad_s, speed_rad_s_);
  const double wanted = actuator_.RigInput(v, speed_rad_s_);
  given_v_ = Limited(std::min(wanted, LargestInput()));
  if (given_v_ != wanted) controller_.Applied(actuator_.ControllerInput(given_v_, speed_rad_s_));
  // Two ticks up, two down: its mean is zero, and the controller does not answer it at once.
  const double dither =
      dithering_ ? ((ticks_ / 2) % 2 == 0 ? options_.dither_v : -options_.dither_v) : 0.0;
  ++ticks_;
  last_u_ = Limited(given_v_ + dither);
  return last_u_;
}

void TolerantDrive::Heard(const Verdict& verdict) {
  if (options_.kind != ControlKind::kCompensated) return;
  const bool named = verdict.kind == VerdictKind::kFault && !verdict.candidates.empty();
  const bool alarmed =
      verdict.kind == VerdictKind::kFault || verdict.kind == VerdictKind::kUnknownFault;
  std::optional<SpeedModel> faulty;
  double gain = rig_.gain();
  if (named) {
    const Candidate& best = verdict.candidates.front();
    const RigParameters rig = WithComponent(rig_, best.component, best.value);
    const bool sure = best.bound == 0 && best.sigma < kSureShare * best.value;
    if (sure || verdict.settled) {
      faulty = SpeedModelOf(rig, period_s_);
      gain = rig.gain();
    }
  }
  dithering_ = alarmed && !faulty;
  // Bumpless: the controller goes on from the input that the rig has now.
  actuator_.Reconfigure(faulty);
  known_ = faulty.value_or(healthy_);
  output_per_input_ = gain;
  controller_.Applied(actuator_.ControllerInput(given_v_, speed_rad_s_));
}

}  // namespace faultlab::core
