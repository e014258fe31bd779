#include "core/calibration/data_sheet.h"

#include <array>
#include <cmath>

#include "core/calibration/calibrate.h"
#include "core/numerics/linear_systems.h"

namespace faultlab::core {
namespace {

// Of delta, in units of a tenth of the period. The published bench: nearly flat over the period.
constexpr double kDeltaTolerance = 1.0;
constexpr double kPublishedDeltaTolerance = 3.5;
// The unit of the coordinate Mc is half of its tolerance.
constexpr double kMcTolerance = 2.0;
// Tolerance of a coordinate that is there and must not move.
constexpr double kHeld = 1e-6;
constexpr std::array<double, 3> kToleranceScales = {1.0, 0.3, 0.1};

// -2 log of the evidence (the probability of the stretch under a prior) by Laplace's approximation,
// up to a constant.
double Evidence(const MapFit& fit, const GaussianPrior& prior) {
  double log_det = LogDeterminant(fit.information + prior.information);
  for (Eigen::Index i = 0; i < prior.information.rows(); ++i) {
    log_det -= std::log(prior.information(i, i));
  }
  return fit.cost() + log_det;
}

}  // namespace

double McUnitOf(const Bench& bench) {
  return bench.norm.mc_sigma_nm / kMcTolerance;
}

ParameterOffsets TolerancesOf(const Bench& bench) {
  const BenchNorm& norm = bench.norm;
  return {norm.gain,
          norm.series,
          norm.ra,
          norm.j,
          norm.b,
          norm.ke,
          kMcTolerance,
          bench.fits_follow_noise ? kDeltaTolerance : kPublishedDeltaTolerance,
          norm.lag > 0.0 ? std::max(norm.la, kHeld) : norm.la,
          norm.lag};
}

GaussianPrior DataSheetPrior(const ParameterOffsets& tolerance, double scale, int n, int zeros) {
  GaussianPrior prior;
  prior.mean = Eigen::VectorXd::Zero(n + zeros);
  prior.information = Eigen::MatrixXd::Identity(n + zeros, n + zeros);
  for (int i = 0; i < n; ++i) {
    // Mc and delta are no parts with a tolerance; La has its own.
    const double sd = tolerance[static_cast<std::size_t>(i)] *
                      (i >= static_cast<int>(Coordinate::kMc) ? 1.0 : scale);
    prior.information(i, i) = 1.0 / (sd * sd);
  }
  return prior;
}

ToleranceChoice ChooseTolerance(const HealthyStretch& stretch,
                                const ParameterOffsets& tolerance,
                                const RigParameters& base,
                                const NoiseLevel& noise,
                                const MapFit& widest) {
  std::array<MapFit, kToleranceScales.size()> fits;
  std::array<double, kToleranceScales.size()> evidence{};
  std::size_t likeliest = 0;
  const auto n = static_cast<int>(widest.point.size());
  const auto zeros = static_cast<int>(stretch.zeros.size());
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const GaussianPrior prior = DataSheetPrior(tolerance, kToleranceScales[i], n - zeros, zeros);
    fits[i] = i == 0 ? widest : FitRig(stretch, base, noise, prior, widest.point);
    evidence[i] = Evidence(fits[i], prior);
    if (evidence[i] < evidence[likeliest]) likeliest = i;
  }
  ToleranceChoice choice;
  choice.fit = fits[likeliest];
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(n, n);
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

}  // namespace faultlab::core
