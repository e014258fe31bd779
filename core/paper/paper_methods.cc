#include "core/paper/paper_methods.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numerics/golden_section.h"
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
  // Eq. (42), (43), units as the paper has them: no scaling of the coefficients.
  const double step = column.dot(change) / column.squaredNorm();
  InverseSolution solution;
  solution.component = component;
  solution.value = nominal.Get(component) + step;
  solution.exists = solution.value > 0.0;
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
  // Seven decades either way hold every value from short to open; C8 starts at 47 pF.
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
  // A component that leaves half of the change unexplained is not its cause.
  solution.exists = solution.mismatch < 0.5;
  return solution;
}

// Fig. 21 against Eq. (4): R9 and R12 scale b0 and b1 alone; C8, Ra and J leave b0; of these J
// keeps b1/a1, Ra moves it with a1, C8 against a1; R1 and B move b0, R1 against a1, B along with
// it.
void Decide(const Vector3& nominal,
            const Vector3& estimate,
            const Vector3& band,
            PaperMethods& out) {
  const Vector3 change = estimate - nominal;
  const auto ask =
      [&out](
          std::string question, bool answer, double value, double threshold, std::string leads_to) {
        out.path.push_back({std::move(question), answer, value, threshold, std::move(leads_to)});
        return answer;
      };
  const bool b0_out = std::abs(change(0)) > band(0);
  const bool b1_out = std::abs(change(1)) > band(1);
  const bool a1_out = std::abs(change(2)) > band(2);
  if (!ask("a1 outside its band?", a1_out, change(2), band(2), a1_out ? "b0" : "gain")) {
    if (ask("b0 outside its band?", b0_out, change(0), band(0), b0_out ? "R9 or R12" : "b1")) {
      out.named = {Component::kR9, Component::kR12};
    } else {
      ask("b1 outside its band?", b1_out, change(1), band(1), b1_out ? "no component" : "nominal");
    }
    return;
  }
  if (ask("b0 outside its band?", b0_out, change(0), band(0), b0_out ? "R1 or B" : "C8, Ra or J")) {
    const bool against = change(0) * change(2) < 0.0;
    ask("a1 and b0 in opposite directions?", against, change(2), 0.0, against ? "R1" : "B");
    out.named = {against ? Component::kR1 : Component::kB};
    return;
  }
  const double ratio = estimate(1) / estimate(2) - nominal(1) / nominal(2);
  const double ratio_band =
      (band(1) + std::abs(nominal(1) / nominal(2)) * band(2)) / std::abs(estimate(2));
  if (!ask("b1/a1 outside its band?",
           std::abs(ratio) > ratio_band,
           ratio,
           ratio_band,
           std::abs(ratio) > ratio_band ? "C8 or Ra" : "J")) {
    out.named = {Component::kJ};
    return;
  }
  const bool along = ratio * change(2) > 0.0;
  ask("b1/a1 and a1 in the same direction?", along, ratio, 0.0, along ? "Ra" : "C8");
  out.named = {along ? Component::kRa : Component::kC8};
}

}  // namespace

ContinuousTheta FirstOrderTheta(const PlantParameters& plant, double gain_factor) {
  const ContinuousCoefficients c = MakeContinuous(plant);
  return {gain_factor * c.b0, gain_factor * c.b1, c.a1};
}

std::array<std::array<double, kComponentCount>, 3> FirstOrderJacobian(
    const PlantParameters& plant) {
  const CoefficientJacobian jacobian = ContinuousJacobian(plant);
  std::array<std::array<double, kComponentCount>, 3> rows{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < kComponentCount; ++c) {
      rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)] = jacobian(r, c);
    }
  }
  return rows;
}

PaperMethods RunPaperMethods(const PlantParameters& nominal,
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
  Decide(at_nominal, at_estimate, half, out);

  const CoefficientJacobian jacobian = ContinuousJacobian(nominal);
  const double gain_factor = nominal_theta[0] / FirstOrderTheta(nominal)[0];
  CoefficientJacobian scaled;
  for (Component component : kAllComponents) {
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
  for (Component component : kAllComponents) {
    out.full_jacobian_values[static_cast<std::size_t>(Index(component))] =
        nominal.Get(component) * (1.0 + step(Index(component)));
  }
  return out;
}

}  // namespace faultlab::core
