#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/calibration/channel_zeros.h"
#include "core/calibration/clean_stretch.h"
#include "core/calibration/coordinate_quantities.h"
#include "core/calibration/data_sheet.h"
#include "core/calibration/missing_physics.h"
#include "core/calibration/reading_shapes.h"
#include "core/calibration/reading_steps.h"
#include "core/calibration/self_check.h"
#include "core/calibration/stretch_checks.h"
#include "core/calibration/stretch_fit.h"
#include "core/calibration/usual_suspects.h"
#include "core/calibration/visible_changes.h"
#include "core/detection/detection_thresholds.h"
#include "core/filter/map_fit.h"
#include "core/filter/observation.h"

namespace faultlab::core {
namespace {

// A measured delta is believed within this, seconds: it tells when the calls were made, not what
// the converters and their wires add.
constexpr double kMeasuredDeltaSigmaS = 0.1e-3;
// Where a stretch with small steps does not tell delta, it is expected as described within this,
// seconds; more is told of a rig while it runs (hardware/delta_watch.h).
constexpr double kDescribedDeltaSigmaS = 0.2e-3;

int CoordinateCountOf(const BenchNorm& norm) {
  if (norm.lag > 0.0) return kCoordinateMax;
  return norm.la > 0.0 ? kCoordinateCountWithLa : kCoordinateCount;
}

// What delta is before anything is fitted, and within what.
struct ExpectedDelta {
  double delta_s;
  double sigma_s;
};

ExpectedDelta DescribedDelta(const CalibrationOptions& options) {
  return {options.bench->ReadingDelay(options.bench->delta_s, options.period_s),
          kDescribedDeltaSigmaS};
}

// The mean of the measured deltas; none unless most samples carry one.
std::optional<ExpectedDelta> MeasuredDelta(std::span<const Sample> samples,
                                           const CalibrationOptions& options) {
  const double period_s = options.period_s;
  double sum_s = 0.0;
  std::size_t measured = 0;
  for (const Sample& sample : samples) {
    if (!(sample.delta_s > 0.0 && sample.delta_s < period_s)) continue;
    sum_s += sample.delta_s;
    ++measured;
  }
  if (measured == 0 || 2 * measured < samples.size()) return std::nullopt;
  const double mean_s = sum_s / static_cast<double>(measured);
  return ExpectedDelta{options.bench->ReadingDelay(mean_s, period_s), kMeasuredDeltaSigmaS};
}

// Where one part alone is the gain, what the gain is off the data sheet is off that part: a fault
// that replaces the part replaces the offset too.
RigParameters WithGainInItsPart(const RigParameters& rig) {
  const int part = GainPartOf(rig.plant);
  if (part < 0) return rig;
  RigParameters moved = rig;
  moved.plant.amplifier[static_cast<std::size_t>(part - kMotorParameters)] *= rig.gain_factor;
  moved.gain_factor = 1.0;
  return moved;
}

// The upper left n x n of a matrix, row by row.
std::vector<double> FirstRows(const Eigen::MatrixXd& of, int n) {
  const Eigen::MatrixXd part = of.topLeftCorner(n, n);
  return {part.data(), part.data() + part.size()};
}

// True where the fit, in which delta was free, does not tell it, or has gone to an end of the
// period, where nothing depends on it.
bool DeltaIsUntold(const MapFit& fit, double period_s) {
  constexpr auto kDelta = static_cast<Eigen::Index>(Coordinate::kDelta);
  const double sigma_s = std::sqrt(fit.covariance(kDelta, kDelta)) * kDeltaUnitPeriods * period_s;
  return sigma_s > kDescribedDeltaSigmaS;
}

// @param expected  none: what the bench expects of a record that says nothing of it
Result<Calibration> CalibrateWith(std::span<const Sample> samples,
                                  const CalibrationOptions& options,
                                  const std::optional<ExpectedDelta>& expected) {
  const BenchNorm& norm = options.bench->norm;
  ParameterOffsets tolerance = TolerancesOf(*options.bench);
  const double period_s = options.period_s;
  std::optional<double> expected_delta_s;
  if (expected) {
    expected_delta_s = expected->delta_s;
    tolerance[static_cast<std::size_t>(Coordinate::kDelta)] =
        expected->sigma_s / (kDeltaUnitPeriods * period_s);
  }
  const std::vector<Observation> as_read = ReadingsOf(samples, options).observations;
  Calibration calibration;
  calibration.period_s = period_s;
  if (!samples.empty()) {
    calibration.from_s = samples.front().t_s;
    calibration.to_s = samples.back().t_s + period_s;
  }
  if (std::optional<Error> refusal =
          CheckBefore(*options.bench, as_read, period_s, calibration.checks))
    return *refusal;
  calibration.samples = static_cast<int>(as_read.size());

  unsigned mask = 0;
  for (const Observation& o : as_read) mask |= o.mask;
  calibration.used_um = (mask & 1U) != 0U;
  calibration.used_ia = (mask & 2U) != 0U;
  calibration.used_n = (mask & 4U) != 0U;

  const int coordinates = CoordinateCountOf(norm);
  const RigParameters data_sheet{
      options.data_sheet, 1.0, 0.0, norm.mc_nm, McUnitOf(*options.bench)};
  CleanStretch clean(samples,
                     options,
                     mask,
                     data_sheet,
                     DataSheetPrior(tolerance, 1.0, coordinates, 0),
                     expected_delta_s);
  const bool delta_is_free = !expected && !options.bench->fits_follow_noise;
  // By um alone J and Ra are no surer than delta.
  const bool by_um_alone = !calibration.used_ia && !calibration.used_n;
  if (delta_is_free && !by_um_alone && DeltaIsUntold(clean.explained().fit, period_s))
    return CalibrateWith(samples, options, DescribedDelta(options));
  clean.TakeOut();
  clean.Tell(calibration);
  HealthyStretch stretch = clean.stretch();
  Explained explained = clean.explained();
  if (std::optional<WithZeros> with =
          LearnZeros(stretch, data_sheet, tolerance, expected_delta_s, explained)) {
    stretch = std::move(with->stretch);
    explained = std::move(with->explained);
  }
  const RigParameters& base = explained.base;
  const NoiseLevel& noise = explained.noise;
  MapFit best = explained.fit;
  const double data_sheet_cost = best.prior_cost;
  // Without a voltage the data tell the parameters up to a common factor: they may agree with the
  // data sheet by chance, and say nothing of its tolerances.
  ToleranceChoice choice{best,
                         Eigen::MatrixXd::Zero(best.covariance.rows(), best.covariance.cols())};
  if (calibration.used_um) {
    choice = ChooseTolerance(stretch, tolerance, base, noise, best);
  }
  best = choice.fit;
  const RigParameters rig = WithGainInItsPart(RigAt(stretch, base, best.point));

  calibration.nominal = rig.plant;
  calibration.gain_factor = rig.gain_factor;
  calibration.lag_factor = rig.lag_factor;
  calibration.delta_s = rig.delta_s;
  calibration.mc_nm = std::max(0.0, rig.mc_nm);
  calibration.mc_unit_nm = rig.mc_unit_nm;
  calibration.um_noise_v = noise.um_v;
  calibration.ia_noise_a = noise.ia_a;
  calibration.n_noise_rpm = noise.w_rad_s / RadPerSecondOfRpm(options.data_sheet.gear_ratio);
  calibration.friction_noise_nm = noise.friction_nm;
  calibration.friction_tau_s = noise.friction_tau_s;
  calibration.um_zero_v = rig.zeros[0];
  calibration.ia_zero_a = rig.zeros[1];
  calibration.n_zero_rpm = rig.zeros[2] / RadPerSecondOfRpm(options.data_sheet.gear_ratio);
  // The zeros are known from here on; what they leave unknown of the others is in their covariance.
  calibration.covariance = FirstRows(best.covariance, coordinates);
  calibration.tolerance_covariance = FirstRows(choice.tolerance_covariance, coordinates);
  calibration.part_tolerance = tolerance[0] * choice.tolerance_scale;
  for (int i = 0; i < coordinates; ++i) {
    const auto at = static_cast<std::size_t>(i);
    CalibratedQuantity quantity;
    quantity.name = SymbolOf(options.data_sheet, i);
    quantity.unit = UnitOf(options.data_sheet, i);
    quantity.value = ValueOf(rig, i);
    const double sigma = std::sqrt(std::max(0.0, best.covariance(i, i)) +
                                   std::max(0.0, choice.tolerance_covariance(i, i)));
    quantity.sigma = SigmaOf(rig, i, sigma, period_s);
    quantity.prior_value = ValueOf(base, i);
    const double own = tolerance[at];
    if (delta_is_free && i == static_cast<int>(Coordinate::kDelta)) {
      quantity.prior_value = 0.5 * period_s;
    }
    quantity.prior_sigma = SigmaOf(base, i, own, period_s);
    // Compared with the scaled tolerance: an error that shrank only with the tolerance scale does
    // not come from the data.
    const double used = i < static_cast<int>(Coordinate::kMc) ? own * choice.tolerance_scale : own;
    quantity.from_data = sigma < 0.5 * used;
    calibration.quantities.push_back(quantity);
  }
  AddZeros(stretch, rig, best.covariance + choice.tolerance_covariance, calibration.quantities);
  calibration.mc_sigma_nm = calibration.quantities[static_cast<std::size_t>(Coordinate::kMc)].sigma;

  if (std::optional<Error> refusal = CheckAfter(*options.bench,
                                                rig,
                                                noise,
                                                period_s,
                                                stretch.samples,
                                                data_sheet_cost,
                                                calibration.quantities,
                                                static_cast<std::size_t>(coordinates),
                                                calibration.checks,
                                                calibration.model_error)) {
    return *refusal;
  }
  SaySteps(samples, calibration);
  const bool lacks = options.model == ModelScope::kAsDescribed
                         ? norm.missing_physics
                         : options.model == ModelScope::kBuiltRig;
  Eigen::MatrixXd missing = Eigen::MatrixXd::Zero(coordinates, coordinates);
  if (lacks) {
    missing = MissingPhysics(stretch, base, best, noise);
    calibration.model_covariance = FirstRows(missing, coordinates);
  }
  const ParameterOffsets walk = WalkOf(calibration.model_error);
  for (int i = 0; i < coordinates; ++i) {
    const auto at = static_cast<std::size_t>(i);
    double& sigma = calibration.quantities[at].sigma;
    const double more = std::hypot(std::sqrt(missing(i, i)), walk[at]);
    if (more > 0.0) sigma = std::hypot(sigma, SigmaOf(rig, i, more, period_s));
  }
  calibration.thresholds = MakeThresholds(options.false_alarms_per_day, 1.0 / period_s, mask);
  const std::optional<SelfCheck> check =
      CheckBySelf(calibration,
                  stretch,
                  clean.with_impulses(),
                  base,
                  best.point,
                  noise,
                  DataSheetPrior(tolerance, choice.tolerance_scale, coordinates, 0));
  if (check) {
    calibration.thresholds = check->thresholds;
    calibration.model_error = check->error;
    calibration.checks.push_back(CheckOf(*check));
  } else {
    calibration.checks.push_back(
        {"own stretch",
         "too short, or its input steps too seldom, to be judged by its own halves: alarm levels "
         "are those of noise alone, and what the model does not describe may raise false alarms",
         0.0,
         0.0,
         true});
  }
  std::vector<Observation> trusted(stretch.samples.begin(), stretch.samples.end());
  GiveTrust(calibration.model_error, period_s, trusted);
  stretch.samples = trusted;
  const std::string visible = TextOf(VisibleChanges(stretch,
                                                    RigAt(stretch, base, best.point),
                                                    noise,
                                                    calibration.thresholds,
                                                    calibration.model_error));
  if (!visible.empty())
    calibration.checks.push_back(
        {"visible", "an alarm follows a change of " + visible, 0.0, 0.0, true});
  return calibration;
}

Result<Calibration> Learn(std::span<const Sample> samples, const CalibrationOptions& options) {
  LAB_CHECK(options.bench != nullptr);
  return CalibrateWith(samples, options, MeasuredDelta(samples, options));
}

/// The checks that a wrong unit fails.
bool SpeaksOfTheFit(const Error& refusal) {
  constexpr std::array<std::string_view, 6> kOfTheFit = {
      "excitation", "noise", "friction", "tolerance", "stationarity", "residual"};
  return std::find(kOfTheFit.begin(), kOfTheFit.end(), refusal.field) != kOfTheFit.end();
}

std::optional<std::string> SuspectOf(std::span<const Sample> samples,
                                     const CalibrationOptions& options,
                                     const Result<Calibration>& calibration) {
  // A simulator writes its own record: nothing is wrong with that.
  const bool tried = !calibration.ok() && options.model != ModelScope::kSimulator;
  if (!tried || !SpeaksOfTheFit(calibration.error())) return std::nullopt;
  return UsualSuspect(
      samples, options, [&](std::span<const Sample> mended) { return Learn(mended, options); });
}

/// Channels that do not fit, as bits: all of a stretch that does not; of one that does, those with
/// much more noise than is stated.
unsigned LeavesTooMuch(std::span<const Sample> samples,
                       const CalibrationOptions& options,
                       const Result<Calibration>& calibration) {
  constexpr double kMuch = 2.0;
  const Bench& bench = *options.bench;
  if (calibration.ok()) {
    const Calibration& of = calibration.value();
    return (of.used_um && of.um_noise_v > kMuch * bench.um.noise ? 1U : 0U) |
           (of.used_ia && of.ia_noise_a > kMuch * bench.ia.noise ? 2U : 0U) |
           (of.used_n && of.n_noise_rpm > kMuch * bench.n.noise ? 4U : 0U);
  }
  if (!SpeaksOfTheFit(calibration.error()) || calibration.error().field == "excitation") return 0U;
  unsigned mask = 0;
  for (const Observation& o : ReadingsOf(samples, options).observations) mask |= o.mask;
  return mask;
}

}  // namespace

Result<Calibration> Calibrate(std::span<const Sample> samples, const CalibrationOptions& options) {
  Result<Calibration> calibration = Learn(samples, options);
  if (const unsigned mask = LeavesTooMuch(samples, options, calibration)) {
    if (std::optional<Error> refusal = CheckShapes(*options.bench, samples, mask)) return *refusal;
  }
  if (calibration.ok() && options.model != ModelScope::kSimulator) {
    const auto learn = [&](std::span<const Sample> mended) { return Learn(mended, options); };
    const auto smoothed = SmoothedChannel(samples, options, calibration.value(), learn);
    if (smoothed)
      return Error{
          ErrorCode::kInvalid, "not calibrated, check 'noise' failed: " + *smoothed, "noise"};
  }
  const std::optional<std::string> wrong = SuspectOf(samples, options, calibration);
  if (!wrong) return calibration;
  Error error = calibration.error();
  error.message += "; " + *wrong;
  return error;
}

bool Fits(std::span<const Sample> samples, const CalibrationOptions& options) {
  return Learn(samples, options).ok();
}

std::optional<std::string> WhatIsWrong(std::span<const Sample> samples,
                                       const CalibrationOptions& options) {
  return SuspectOf(samples, options, Learn(samples, options));
}

}  // namespace faultlab::core
