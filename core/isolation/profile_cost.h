#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "core/isolation/fit_context.h"

namespace faultlab::core {

/// The range in which the value of a component is searched, SI unit; its ends only bound the
/// search.
struct ValueRange {
  double low;
  double high;
  int points;  ///< of a scan

  /// The points are equally spaced in the logarithm.
  double LogAt(int point) const {
    return std::log(low) + point * ((std::log(high) - std::log(low)) / (points - 1));
  }
};
ValueRange RangeOf(Component component);

/// The cost of HypothesisFit as a function of one component's value. The calibration's coordinates
/// are held at zero, except Mc, which enters linearly and is minimised over under its marginal
/// prior:
///   cost = sum z^2 + sum log S - mc_cross^2 / (mc_square + information of Mc)
/// in the same unit as HypothesisFit::cost, but without the prior of the other coordinates: profile
/// costs are comparable with each other only.
/// Source: profile likelihood, S. A. Murphy, A. W. van der Vaart, J. Am. Stat. Assoc. 95 (2000).
class ProfileCost {
 public:
  struct Point {
    Component component;
    double log_value;  ///< natural logarithm of the value in its SI unit
  };
  struct Result {
    double cost = 0.0;  ///< the largest double if the predictions are not finite
    double chi2 = 0.0;  ///< with Mc held
    int count = 0;
  };

  explicit ProfileCost(const FitContext& context);

  /// The costs of all points, computed side by side. The result is valid until the next call.
  const std::vector<Result>& At(std::span<const Point> points,
                                std::span<const Observation> stretch);
  double At(const Point& point, std::span<const Observation> stretch) {
    return At(std::span<const Point>(&point, 1), stretch).front().cost;
  }

 private:
  const FitContext& context_;
  double mc_information_;
  std::vector<PredictionModel> models_;
  std::vector<ModelSegment> segments_;
  std::vector<ModelPath> paths_;
  std::vector<InnovationSummary> sums_;
  std::vector<Result> results_;
};

}  // namespace faultlab::core
