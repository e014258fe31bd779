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
#include "core/plant/coefficients.h"
#include "core/structures/inverting_amplifier/inverting_amplifier.h"
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

// Parts of the amplifier that change its gain, or its lag alone.
constexpr std::array<std::string_view, 5> kGain = {"R9", "R10", "R12", "R14", "R15"};
constexpr std::array<std::string_view, 1> kLag = {"C8"};
constexpr std::array<std::string_view, 1> kSeries = {"R1"};
constexpr std::array<std::string_view, 1> kFriction = {"B"};
constexpr std::array<std::string_view, 1> kRa = {"Ra"};
constexpr std::array<std::string_view, 1> kJ = {"J"};

// The decisions of Fig. 21, derived from Eq. (4): the gain (R9, R12) scales only b0 and b1. The lag
// (C8), Ra and J do not change b0; of these, J keeps b1/a1, Ra changes b1/a1 in the same direction
// as a1, C8 in the opposite direction. R1 and B change b0, R1 in the opposite direction to a1, B in
// the same direction.
class Decisions {
 public:
  Decisions(const Bench& bench, PaperMethods& out) : bench_(bench), out_(out) {}

  void Decide(const Vector3& nominal, const Vector3& estimate, const Vector3& band) {
    const Vector3 change = estimate - nominal;
    const bool b0_out = std::abs(change(0)) > band(0);
    const bool b1_out = std::abs(change(1)) > band(1);
    const bool a1_out = std::abs(change(2)) > band(2);
    if (!Ask("a1 outside its band?", a1_out, change(2), band(2), "b0")) {
      if (b0_out) {
        AskFor("b0 outside its band?", true, change(0), band(0), Changing(kGain));
        return;
      }
      Ask("b0 outside its band?", false, change(0), band(0), "b1");
      if (b1_out) {
        AskFor("b1 outside its band?", true, change(1), band(1), {});
      } else {
        Ask("b1 outside its band?", false, change(1), band(1), "nominal");
      }
      return;
    }
    const auto series = Changing(kSeries);
    const auto friction = Changing(kFriction);
    const auto lag = Changing(kLag);
    const auto ra = Changing(kRa);
    const auto j = Changing(kJ);
    if (AskFor("b0 outside its band?",
               b0_out,
               change(0),
               band(0),
               b0_out ? Both(series, friction) : Both(Both(lag, ra), j))) {
      const bool against = change(0) * change(2) < 0.0;
      AskFor("a1 and b0 in opposite directions?",
             against,
             change(2),
             0.0,
             against ? series : friction);
      return;
    }
    const double ratio = estimate(1) / estimate(2) - nominal(1) / nominal(2);
    const double ratio_band =
        (band(1) + std::abs(nominal(1) / nominal(2)) * band(2)) / std::abs(estimate(2));
    const bool ratio_out = std::abs(ratio) > ratio_band;
    if (!AskFor("b1/a1 outside its band?",
                ratio_out,
                ratio,
                ratio_band,
                ratio_out ? Both(lag, ra) : j)) {
      return;
    }
    const bool along = ratio * change(2) > 0.0;
    AskFor("b1/a1 and a1 in the same direction?", along, ratio, 0.0, along ? ra : lag);
  }

 private:
  using Components = std::vector<Component>;

  bool Ask(
      std::string question, bool answer, double value, double threshold, std::string leads_to) {
    out_.path.push_back({std::move(question), answer, value, threshold, std::move(leads_to), {}});
    return answer;
  }

  /// A question after which these components alone are possible.
  bool AskFor(
      std::string question, bool answer, double value, double threshold, Components components) {
    Ask(std::move(question), answer, value, threshold, Words(components));
    out_.path.back().components = std::move(components);
    return answer;
  }

  /// The bench's components whose faults change these parameters of the structure.
  Components Changing(std::span<const std::string_view> symbols) const {
    Components found;
    for (const Component component : bench_.components()) {
      const auto parameter = static_cast<std::size_t>(component.info().parameter);
      const std::string_view symbol = bench_.structure->parameters[parameter].symbol;
      if (std::find(symbols.begin(), symbols.end(), symbol) != symbols.end()) {
        found.push_back(component);
      }
    }
    return found;
  }

  static Components Both(Components first, const Components& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
  }

  static std::string Words(const Components& components) {
    if (components.empty()) return "no component";
    std::string words;
    for (std::size_t i = 0; i < components.size(); ++i) {
      if (i > 0) words += i + 1 == components.size() ? " or " : ", ";
      words += Name(components[i]);
    }
    return words;
  }

  const Bench& bench_;
  PaperMethods& out_;
};

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
  const bool published = !bench.published.source.empty();
  if (published && bench.structure == &kInvertingAmplifier) {
    Decisions(bench, out).Decide(at_nominal, at_estimate, half);
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
