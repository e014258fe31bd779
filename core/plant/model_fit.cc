#include "core/plant/model_fit.h"

#include <cmath>
#include <limits>
#include <numeric>

#include "core/numerics/linear_systems.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
// Free responses that differ by less than this cannot be distinguished; the smallest state is used.
constexpr double kRankTolerance = 1e-9;

/// The sum forced + columns * c that is closest to measured.
ModelFit FitInitialStates(std::vector<double> forced,
                          const Eigen::MatrixXd& columns,
                          std::span<const double> measured) {
  const auto rows = static_cast<Eigen::Index>(forced.size());
  Eigen::Map<Eigen::VectorXd> simulated(forced.data(), rows);
  const Eigen::Map<const Eigen::VectorXd> target(measured.data(), rows);
  ModelFit fit;
  if (rows == 0 || !simulated.allFinite() || !columns.allFinite() || !target.allFinite()) {
    fit.fit_percent = kNotANumber;
    fit.simulated.assign(measured.size(), kNotANumber);
    return fit;
  }
  simulated += columns * LeastSquares(columns, target - simulated, kRankTolerance);
  fit.simulated = std::move(forced);
  fit.fit_percent = CompareFit(measured, fit.simulated);
  return fit;
}

/// y(k) of the discrete model from x(0) = 0: y = b0d u + x, x(k+1) = b1d u(k) - a1d y(k).
std::vector<double> Forced(const DiscreteCoefficients& model, std::span<const double> uc_v) {
  std::vector<double> y(uc_v.size());
  double x = 0.0;
  for (std::size_t k = 0; k < uc_v.size(); ++k) {
    y[k] = model.b0d * uc_v[k] + x;
    x = model.b1d * uc_v[k] - model.a1d * y[k];
  }
  return y;
}

/// base^k, k = 0 .. rows-1.
Eigen::VectorXd Powers(double base, std::size_t rows) {
  Eigen::VectorXd powers(static_cast<Eigen::Index>(rows));
  double power = 1.0;
  for (double& value : powers) {
    value = power;
    power *= base;
  }
  return powers;
}

/// Output of 1/(a12 s + 1), read `delta_s` after the edges of `directions`, which are 1 throughout
/// if there are none.
std::vector<double> FrictionChannel(std::span<const double> directions,
                                    double a12_s,
                                    double period_s,
                                    double delta_s,
                                    std::size_t samples) {
  std::vector<double> out(samples, 1.0);
  LAB_CHECK(directions.empty() || directions.size() == samples, directions.size(), samples);
  const double over_period = std::exp(-period_s / a12_s);
  const double over_delta = std::exp(-delta_s / a12_s);
  double state = 0.0;
  for (std::size_t k = 0; k < directions.size(); ++k) {
    out[k] = directions[k] + (state - directions[k]) * over_delta;
    state = directions[k] + (state - directions[k]) * over_period;
  }
  return out;
}

ModelFit NoFit(std::size_t samples) {
  return {.fit_percent = kNotANumber, .simulated = std::vector<double>(samples, kNotANumber)};
}

}  // namespace

double CompareFit(std::span<const double> measured, std::span<const double> simulated) {
  if (measured.empty() || measured.size() != simulated.size()) {
    return kNotANumber;
  }
  const double mean =
      std::accumulate(measured.begin(), measured.end(), 0.0) / static_cast<double>(measured.size());
  double error = 0.0;
  double variation = 0.0;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    error += (measured[k] - simulated[k]) * (measured[k] - simulated[k]);
    variation += (measured[k] - mean) * (measured[k] - mean);
  }
  if (!(variation > 0.0) || !std::isfinite(error)) {
    return kNotANumber;
  }
  return 100.0 * (1.0 - std::sqrt(error / variation));
}

ModelFit FitDiscrete(const DiscreteCoefficients& model,
                     std::span<const double> uc_v,
                     std::span<const double> y_measured) {
  LAB_CHECK(uc_v.size() == y_measured.size(), uc_v.size(), y_measured.size());
  return FitInitialStates(Forced(model, uc_v), Powers(-model.a1d, uc_v.size()), y_measured);
}

ModelFit FitContinuous(const ContinuousCoefficients& model,
                       std::span<const double> uc_v,
                       std::span<const double> y_measured,
                       double period_s,
                       double delta_s) {
  if (!(model.a1 > 0.0)) {
    return NoFit(y_measured.size());
  }
  return FitDiscrete(Discretise(model, period_s, delta_s), uc_v, y_measured);
}

ModelFit FitFriction(const ContinuousCoefficients& model,
                     double mc_nm,
                     std::span<const double> uc_v,
                     std::span<const double> y_measured,
                     double period_s,
                     double delta_s,
                     std::span<const double> directions) {
  LAB_CHECK(uc_v.size() == y_measured.size(), uc_v.size(), y_measured.size());
  if (!(model.a1 > 0.0 && model.a12 > 0.0)) {
    return NoFit(y_measured.size());
  }
  const DiscreteCoefficients discrete = Discretise(model, period_s, delta_s);
  std::vector<double> forced = Forced(discrete, uc_v);
  const std::vector<double> friction =
      FrictionChannel(directions, model.a12, period_s, delta_s, forced.size());
  for (std::size_t k = 0; k < forced.size(); ++k) {
    forced[k] -= model.b02 * mc_nm * friction[k];
  }
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(uc_v.size()), 2);
  columns.col(0) = Powers(-discrete.a1d, uc_v.size());
  columns.col(1) = Powers(std::exp(-period_s / model.a12), uc_v.size());
  return FitInitialStates(std::move(forced), columns, y_measured);
}

ModelFit FitSampled(const SampledModel& model,
                    int row,
                    double mc_nm,
                    std::span<const double> uc_v,
                    std::span<const double> y_measured) {
  LAB_CHECK(uc_v.size() == y_measured.size(), uc_v.size(), y_measured.size());
  std::vector<double> forced(uc_v.size());
  Simulate(model,
           row,
           uc_v,
           mc_nm,
           Eigen::Vector3d::Zero(),
           forced,
           FrictionDirections(model, uc_v, mc_nm));
  Eigen::MatrixXd columns(static_cast<Eigen::Index>(uc_v.size()), 3);
  Eigen::RowVector3d response = model.c.row(row);
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    columns.row(k) = response;
    const Eigen::RowVector3d next = response * model.phi;
    response = next;
  }
  for (Eigen::Index j = 0; j < 3; ++j) {  // without units: all states are treated alike
    const double norm = columns.col(j).norm();
    if (norm > 0.0) {
      columns.col(j) /= norm;
    }
  }
  return FitInitialStates(std::move(forced), columns, y_measured);
}

}  // namespace faultlab::core
