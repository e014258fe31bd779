#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/isolability/isolability_options.h"
#include "core/types/calibration.h"
#include "core/types/component.h"
#include "core/types/plant_parameters.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// The 18 faults of the paper (Tables 3-10).
std::span<const FaultSize> PaperFaultSizes();

/// The smallest fault of one component that the window shows.
struct SmallestVisible {
  Component component = Component::kR1;
  double nominal = 0.0;
  std::optional<double> below;  ///< largest visible value under nominal; none: no such fault shows
  std::optional<double> above;  ///< smallest visible value over nominal
  /// Cramer-Rao bound of log(value) at nominal when this component alone is unknown: the relative
  /// standard error that no estimator can beat. Infinite when the window does not contain it.
  double relative_sigma = 0.0;
};

/// The nearest that faults of one component come to a given fault.
struct NearestRival {
  double kl_nats = 0.0;  ///< Kullback-Leibler distance, of the whole window
  double value = 0.0;    ///< of the rival component, where that is reached
};

/// What can be told about one fault of the set.
struct FaultIsolability {
  FaultSize fault;
  double kl_nominal_nats = 0.0;  ///< distance from the healthy rig
  bool visible = false;
  std::array<NearestRival, kComponentCount> rival;  ///< own component: zero at its own value
  std::vector<Component> group;  ///< itself first, then all that it can be taken for
};

/// A fault set on one rig, judged. Distances are the mean part of the Kullback-Leibler divergence
/// between the records of two rigs that were alike until the fault,
///   D(a, b) = 1/2 sum over the window of |S_b^-1/2 (E_a[y] - yhat_b)|^2,
/// with yhat_b the prediction of b's Kalman filter: noise, friction and what the filter can learn
/// about its state are all in it. A test between a and b errs with probability
/// Phi(-sqrt(2 D) / 2); a matched detector with threshold z sees a with Phi(sqrt(2 D) - z).
struct Isolability {
  /// Information about log(component) of all pairs at nominal, rows and columns as kAllComponents.
  Eigen::Matrix<double, kComponentCount, kComponentCount> fisher;
  /// Cosine between the effects of two components: 1 means that small faults look alike.
  Eigen::Matrix<double, kComponentCount, kComponentCount> overlap;
  std::array<SmallestVisible, kComponentCount> smallest;
  std::vector<FaultIsolability> faults;
  /// Components whose small faults have the same effect (overlap 1 up to kSameEffect): no amount of
  /// data of this kind tells them apart. Singles left out.
  std::vector<std::vector<Component>> ambiguous;
  double kl_visible_nats = 0.0;    ///< distance that `visible` asks for
  double kl_separable_nats = 0.0;  ///< distance that telling apart asks for
};

/// Share of a component's effect that another one must leave unexplained to count as different.
inline constexpr double kSameEffect = 1e-6;

/// Judges a fault set. Deterministic, no simulation of noise; some 0.2 s for the paper's 18 faults
/// at 100 samples. Refuses (kInvalid, field) options outside the ranges above.
/// Source: Kullback-Leibler distances as Eriksson, Frisk, Krysander, "A method for quantitative
/// fault diagnosability analysis of stochastic linear descriptor models", Automatica 49 (2013).
Result<Isolability> AnalyseIsolability(const IsolabilityOptions& options);

}  // namespace faultlab::core
