#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/calibration/calibrate.h"
#include "core/calibration/stretch_checks.h"
#include "core/detection/detection_thresholds.h"
#include "core/filter/map_fit.h"
#include "core/filter/observation.h"

namespace faultlab::core {
namespace {

// Tolerances of a data sheet before anything is measured, one standard deviation. 5 % stands for
// parts and motor constants; B and Mc were found by experiment once (paper Table 1).
// delta: as good as flat over the period.
constexpr ParameterOffsets kTolerance = {0.05, 0.05, 0.05, 0.05, 0.20, 0.03, 2.0, 3.5};
// The paper's own best Coulomb friction (Table 14), and with the tolerance above 0.13 .. 0.53.
constexpr double kCoulombPriorNm = 0.33e-3;
// How far delta and noise can be from the first guess is not known: several starts.
constexpr std::array<double, 3> kDeltaStartShares = {0.95, 0.5, 0.1};
constexpr int kNoiseRounds = 3;
// Friction noise is not visible to every rig: a broad prior on its logarithm keeps it in reach.
constexpr double kFrictionNoisePriorNm = 0.02e-3;
constexpr double kFrictionNoisePriorLogSd = 0.7;
// Readings are never better than their converters (16 bit, 0.3 mV) nor than the model.
constexpr double kNoiseFloorUmV = 2e-4;
constexpr double kNoiseFloorIaA = 3e-5;
constexpr double kNoiseFloorSpeed = 0.01;

// A rig that agrees with its data sheet in all that can be seen is believed to agree in what
// cannot: the tolerances are scaled by the one of these factors that makes the stretch likeliest.
constexpr std::array<double, 3> kToleranceScales = {1.0, 0.3, 0.1};

GaussianPrior DataSheetPrior(double scale) {
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(kCoordinateCount);
  prior.information = Eigen::MatrixXd::Zero(kCoordinateCount, kCoordinateCount);
  for (int i = 0; i < kCoordinateCount; ++i) {
    // Mc and delta are no parts with a tolerance.
    const double sd = kTolerance[static_cast<std::size_t>(i)] *
                      (i >= static_cast<int>(Coordinate::kMc) ? 1.0 : scale);
    prior.information(i, i) = 1.0 / (sd * sd);
  }
  return prior;
}

MapFit FitRig(const RigParameters& base,
              const NoiseLevel& noise,
              double period_s,
              std::span<const Observation> stretch,
              const GaussianPrior& prior,
              const Eigen::VectorXd& start) {
  const StretchModels models{stretch, [&](const Eigen::VectorXd& q, std::size_t) {
                               return MakePredictionModel(
                                   WithOffsets(base, q, period_s), noise, period_s);
                             }};
  return FitMap(models, prior, start);
}

// -2 log of the stretch's probability under a prior, by Laplace's approximation, up to a constant.
double Evidence(const MapFit& fit, const GaussianPrior& prior) {
  const Eigen::MatrixXd posterior = fit.information + prior.information;
  double log_det = posterior.ldlt().vectorD().cwiseMax(1e-12).array().log().sum();
  for (Eigen::Index i = 0; i < prior.information.rows(); ++i) {
    log_det -= std::log(prior.information(i, i));
  }
  return fit.cost() + log_det;
}

// The fit under the likeliest tolerance, and what the others add to its covariance.
struct ToleranceChoice {
  MapFit fit;
  Eigen::MatrixXd tolerance_covariance;
  double tolerance_scale = 1.0;  ///< root mean square over the scales, by their probability
};

// @param widest  the fit under kToleranceScales[0].
ToleranceChoice ChooseTolerance(const RigParameters& base,
                                const NoiseLevel& noise,
                                double period_s,
                                std::span<const Observation> stretch,
                                const MapFit& widest) {
  std::array<MapFit, kToleranceScales.size()> fits;
  std::array<double, kToleranceScales.size()> evidence{};
  std::size_t likeliest = 0;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const GaussianPrior prior = DataSheetPrior(kToleranceScales[i]);
    fits[i] = i == 0 ? widest : FitRig(base, noise, period_s, stretch, prior, widest.point);
    evidence[i] = Evidence(fits[i], prior);
    if (evidence[i] < evidence[likeliest]) likeliest = i;
  }
  ToleranceChoice choice;
  choice.fit = fits[likeliest];
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(kCoordinateCount, kCoordinateCount);
  double total = 0.0;
  double scale_square = 0.0;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const double weight = std::exp(-0.5 * (evidence[i] - evidence[likeliest]));
    const Eigen::VectorXd off = fits[i].point - choice.fit.point;
    spread += weight * (fits[i].covariance + off * off.transpose());
    scale_square += weight * kToleranceScales[i] * kToleranceScales[i];
    total += weight;
  }
  choice.tolerance_covariance = spread / total - choice.fit.covariance;
  choice.tolerance_scale = std::sqrt(scale_square / total);
  return choice;
}

double* NoiseOfChannel(NoiseLevel& noise, std::size_t channel) {
  switch (channel) {
    case 0:
      return &noise.um_v;
    case 1:
      return &noise.ia_a;
    default:
      return &noise.w_rad_s;
  }
}

// Maximum likelihood of the noise levels at fixed parameters: coordinate search in logarithms.
void FitNoise(const RigParameters& rig,
              double period_s,
              std::span<const Observation> stretch,
              unsigned mask,
              NoiseLevel& noise) {
  const auto cost = [&](const NoiseLevel& level) {
    const double friction_off =
        std::log(level.friction_nm / kFrictionNoisePriorNm) / kFrictionNoisePriorLogSd;
    return RunInnovations(MakePredictionModel(rig, level, period_s), stretch).cost() +
           friction_off * friction_off;
  };
  constexpr std::array<double, kOutputCount> kFloor = {
      kNoiseFloorUmV, kNoiseFloorIaA, kNoiseFloorSpeed};
  double best = cost(noise);
  for (double factor : {2.0, 1.4, 1.15, 1.05, 1.015}) {
    for (int pass = 0; pass < 4; ++pass) {
      bool improved = false;
      for (std::size_t c = 0; c <= kOutputCount; ++c) {
        if (c < kOutputCount && (mask & (1U << c)) == 0U) continue;
        for (double move : {factor, 1.0 / factor}) {
          for (int repeat = 0; repeat < 8; ++repeat) {
            NoiseLevel tried = noise;
            double* value = c < kOutputCount ? NoiseOfChannel(tried, c) : &tried.friction_nm;
            *value *= move;
            if (c < kOutputCount && *value < kFloor[c]) break;
            const double tried_cost = cost(tried);
            if (tried_cost >= best - 1e-3) break;
            best = tried_cost;
            noise = tried;
            improved = true;
          }
        }
      }
      if (!improved) break;
    }
  }
}

constexpr std::array<const char*, kCoordinateCount> kNames = {
    "k", "R1", "Ra", "J", "B", "Ke", "Mc", "delta"};
constexpr std::array<const char*, kCoordinateCount> kUnits = {
    "V/V", "ohm", "ohm", "kg m^2", "Nm/(rad/s)", "V/(rad/s)", "Nm", "s"};

double ValueOf(const RigParameters& rig, int coordinate) {
  switch (static_cast<Coordinate>(coordinate)) {
    case Coordinate::kGain:
      return rig.gain();
    case Coordinate::kR1:
      return rig.plant.r1_ohm;
    case Coordinate::kRa:
      return rig.plant.ra_ohm;
    case Coordinate::kJ:
      return rig.plant.j_kg_m2;
    case Coordinate::kB:
      return rig.plant.b_nm_per_rad_s;
    case Coordinate::kKe:
      return rig.plant.ke_v_per_rad_s;
    case Coordinate::kMc:
      return rig.mc_nm;
    case Coordinate::kDelta:
      return rig.delta_s;
  }
  return 0.0;
}

double SigmaOf(const RigParameters& rig, int coordinate, double sigma) {
  if (coordinate == static_cast<int>(Coordinate::kMc)) return sigma * kMcUnitNm;
  if (coordinate == static_cast<int>(Coordinate::kDelta)) return sigma * kDeltaUnitS;
  return ValueOf(rig, coordinate) * sigma;
}

}  // namespace

Result<Calibration> Calibrate(std::span<const Sample> samples, const CalibrationOptions& options) {
  const double period_s = options.period_s;
  const std::vector<Observation> stretch =
      MakeObservations(samples, options.channels, period_s, options.um_rail_v);
  Calibration calibration;
  calibration.period_s = period_s;
  if (!samples.empty()) {
    calibration.from_s = samples.front().t_s;
    calibration.to_s = samples.back().t_s + period_s;
  }
  if (std::optional<Error> refusal = CheckBefore(stretch, calibration.checks)) return *refusal;
  calibration.samples = static_cast<int>(stretch.size());

  unsigned mask = 0;
  for (const Observation& o : stretch) mask |= o.mask;
  calibration.used_ia = (mask & 2U) != 0U;
  calibration.used_n = (mask & 4U) != 0U;

  const GaussianPrior prior = DataSheetPrior(1.0);
  RigParameters base{options.data_sheet, 1.0, 0.5 * period_s, kCoulombPriorNm};
  NoiseLevel noise;
  MapFit best;
  bool have = false;
  for (double share : kDeltaStartShares) {
    RigParameters started = base;
    started.delta_s = share * period_s;
    MapFit fit =
        FitRig(started, noise, period_s, stretch, prior, Eigen::VectorXd::Zero(kCoordinateCount));
    if (!have || fit.cost() < best.cost()) {
      have = true;
      best = fit;
      base = started;
    }
  }
  for (int round = 0; round < kNoiseRounds; ++round) {
    FitNoise(WithOffsets(base, best.point, period_s), period_s, stretch, mask, noise);
    best = FitRig(base, noise, period_s, stretch, prior, best.point);
  }
  const double data_sheet_cost = best.prior_cost;
  const ToleranceChoice choice = ChooseTolerance(base, noise, period_s, stretch, best);
  best = choice.fit;
  const RigParameters rig = WithOffsets(base, best.point, period_s);

  calibration.nominal = rig.plant;
  calibration.gain_factor = rig.gain_factor;
  calibration.delta_s = rig.delta_s;
  calibration.mc_nm = rig.mc_nm;
  calibration.um_noise_v = noise.um_v;
  calibration.ia_noise_a = noise.ia_a;
  calibration.n_noise_rpm = noise.w_rad_s / kRadPerSecondOfRpm;
  calibration.friction_noise_nm = noise.friction_nm;
  calibration.friction_tau_s = noise.friction_tau_s;
  calibration.covariance.assign(best.covariance.data(),
                                best.covariance.data() + best.covariance.size());
  calibration.tolerance_covariance.assign(
      choice.tolerance_covariance.data(),
      choice.tolerance_covariance.data() + choice.tolerance_covariance.size());
  calibration.part_tolerance = kTolerance[0] * choice.tolerance_scale;
  for (int i = 0; i < kCoordinateCount; ++i) {
    const auto at = static_cast<std::size_t>(i);
    CalibratedQuantity quantity;
    quantity.name = kNames[at];
    quantity.unit = kUnits[at];
    quantity.value = ValueOf(rig, i);
    const double sigma = std::sqrt(std::max(0.0, best.covariance(i, i)) +
                                   std::max(0.0, choice.tolerance_covariance(i, i)));
    quantity.sigma = SigmaOf(rig, i, sigma);
    quantity.prior_value = ValueOf(base, i);
    const double tolerance = kTolerance[at];
    if (i == static_cast<int>(Coordinate::kDelta)) quantity.prior_value = 0.5 * period_s;
    quantity.prior_sigma = SigmaOf(base, i, tolerance);
    // Against the scaled tolerance: what the data sheet's own agreement adds is not measured.
    const double used =
        i < static_cast<int>(Coordinate::kMc) ? tolerance * choice.tolerance_scale : tolerance;
    quantity.from_data = sigma < 0.5 * used;
    calibration.quantities.push_back(quantity);
  }
  calibration.mc_sigma_nm = calibration.quantities[static_cast<std::size_t>(Coordinate::kMc)].sigma;

  if (std::optional<Error> refusal = CheckAfter(rig,
                                                noise,
                                                period_s,
                                                stretch,
                                                data_sheet_cost,
                                                calibration.quantities,
                                                calibration.checks)) {
    return *refusal;
  }
  calibration.thresholds = MakeThresholds(options.false_alarms_per_day, 1.0 / period_s, mask);
  return calibration;
}

}  // namespace faultlab::core
