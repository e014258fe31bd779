#include "core/paper/paper_methods.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/numerics/golden_section.h"
#include "core/paper/decisions.h"
#include "core/plant/coefficients.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

using Vector3 = Eigen::Vector3d;

Vector3 ToVector(const ContinuousTheta& theta) {
  return {theta[0], theta[1], theta[2]};
}

double Mismatch(const Vector3& off, const Vector3& change, const Vector3& band) {
  const double all = change.cwiseQuotient(band).norm();
  return all > 0.0 ? off.cwiseQuotient(band).norm() / all : 0.0;
}

InverseSolution SingleColumn(const PlantParameters& nominal,
                             Component component,
                             const Vector3& column,
                             const Vector3& change,
                             const Vector3& band) {
  // Eq. (42), (43) in the paper's units, without scaling of the coefficients.
  const bool moves = !column.isZero(0.0);  // La moves no coefficient of the first order
  const double step = moves ? column.dot(change) / column.squaredNorm() : 0.0;
  InverseSolution solution;
  solution.component = component;
  solution.value = nominal.Get(component) + step;
  solution.exists = moves && solution.value > 0.0;
  solution.mismatch = Mismatch(change - column * step, change, band);
  return solution;
}

InverseSolution ExactInverse(const PlantParameters& nominal,
                             Component component,
                             double gain_factor,
                             const Vector3& estimate,
                             const Vector3& change,
                             const Vector3& band) {
  const auto off_at = [&](double log_value) -> Vector3 {
    PlantParameters changed = nominal;
    changed.Set(component, std::exp(log_value));
    return estimate - ToVector(FirstOrderTheta(changed, gain_factor));
  };
  const auto cost = [&](double log_value) {
    return off_at(log_value).cwiseQuotient(band).squaredNorm();
  };
  // Seven decades either way include every value from short to open circuit; C8 starts at 47 pF.
  constexpr double kDecades = 7.0;
  constexpr int kPoints = 280;
  const double low = std::log(nominal.Get(component)) - kDecades * std::log(10.0);
  const double step = 2.0 * kDecades * std::log(10.0) / kPoints;
  double best = low;
  double best_cost = std::numeric_limits<double>::max();
  for (int i = 0; i <= kPoints; ++i) {
    const double c = cost(low + i * step);
    if (c < best_cost) {
      best_cost = c;
      best = low + i * step;
    }
  }
  constexpr int kGoldenSteps = 60;
  const GoldenSection section = SearchGoldenSection(best - step, best + step, kGoldenSteps, cost);
  const double found = 0.5 * (section.a + section.b);
  InverseSolution solution;
  solution.component = component;
  solution.value = std::exp(found);
  solution.mismatch = Mismatch(off_at(found), change, band);
  // A component that leaves half of the change unexplained is not accepted as its cause.
  solution.exists = solution.mismatch < 0.5;
  return solution;
}

}  // namespace

ContinuousTheta FirstOrderTheta(const PlantParameters& plant, double gain_factor) {
  const ContinuousCoefficients c = MakeContinuous(plant);
  return {gain_factor * c.b0, gain_factor * c.b1, c.a1};
}

PaperMethods RunPaperMethods(const Bench& bench,
                             const PlantParameters& nominal,
                             const ContinuousTheta& nominal_theta,
                             const ContinuousTheta& estimate,
                             const ContinuousTheta& band) {
  LAB_CHECK(band[0] > 0.0 && band[1] > 0.0 && band[2] > 0.0, band[0], band[1], band[2]);
  PaperMethods out;
  out.nominal = nominal_theta;
  out.estimate = estimate;
  out.band = band;
  const Vector3 at_nominal = ToVector(nominal_theta);
  const Vector3 at_estimate = ToVector(estimate);
  const Vector3 half = ToVector(band);
  const Vector3 change = at_estimate - at_nominal;
  if (!change.allFinite()) return out;
  if (HasDecisions(bench)) {
    out.path = FollowDecisions(bench, nominal_theta, estimate, band);
    out.named = out.path.back().components;
  }

  const std::vector<Component> components = bench.components();
  const CoefficientJacobian jacobian = ContinuousJacobian(nominal, components);
  const double gain_factor = nominal_theta[0] / FirstOrderTheta(nominal)[0];
  CoefficientJacobian scaled(3, jacobian.cols());
  out.single_column.resize(components.size());
  out.exact.resize(components.size());
  out.full_jacobian_values.resize(components.size());
  for (Component component : components) {
    const auto at = static_cast<std::size_t>(Index(component));
    const Vector3 column = jacobian.col(Index(component));
    scaled.col(Index(component)) = column.cwiseQuotient(half) * nominal.Get(component);
    out.single_column[at] = SingleColumn(nominal, component, column, change, half);
    out.exact[at] = ExactInverse(nominal, component, gain_factor, at_estimate, change, half);
  }
  // Eq. (35) needs (R'R)^-1 of a 7 x 7 matrix of rank 3: only a pseudo-inverse exists.
  const Eigen::MatrixXd rows = scaled;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
  out.full_jacobian_rank = static_cast<int>(svd.rank());
  out.full_jacobian_condition = std::numeric_limits<double>::infinity();
  const Eigen::VectorXd scaled_change = change.cwiseQuotient(half);
  const Eigen::VectorXd step = svd.solve(scaled_change);
  for (Component component : components) {
    out.full_jacobian_values[static_cast<std::size_t>(Index(component))] =
        nominal.Get(component) * (1.0 + step(Index(component)));
  }
  return out;
}

}  // namespace faultlab::core
