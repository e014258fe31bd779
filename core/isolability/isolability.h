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

/// The faults that the bench proposes: the published ones if there are any, otherwise every value
/// that its relays can connect or its simulators offer.
std::vector<FaultSize> FaultsOf(const Bench& bench);

/// The smallest fault of one component that is visible in the window.
struct SmallestVisible {
  Component component{};
  double nominal = 0.0;
  std::optional<double> below;  ///< largest visible value under nominal; none: no such fault shows
  std::optional<double> above;  ///< smallest visible value over nominal
  /// Cramer-Rao bound of log(value) at nominal when this component alone is unknown: the relative
  /// standard error that no estimator can beat. Infinite when the window does not contain it.
  double relative_sigma = 0.0;
};

/// The fault of one component that is nearest to a given fault.
struct NearestRival {
  Component component{};
  double kl_nats = 0.0;  ///< Kullback-Leibler distance, of the whole window
  double value = 0.0;    ///< value of the rival component at this distance
};

/// What can be distinguished about one fault of the set.
struct FaultIsolability {
  FaultSize fault;
  double kl_nominal_nats = 0.0;  ///< distance from the healthy rig
  bool visible = false;
  std::vector<NearestRival> rival;  ///< for each component of the bench; its own has 0
  std::vector<Component> group;     ///< itself first, then those confused with it
};

/// A fault set on one rig, judged. Distances are the mean part of the Kullback-Leibler divergence
/// between the records of two rigs that were alike until the fault,
///   D(a, b) = 1/2 sum over the window of |S_b^-1/2 (E_a[y] - yhat_b)|^2,
/// with yhat_b the prediction of b's Kalman filter. The distance includes noise, friction, and what
/// the filter can estimate of its state. A test between a and b errs with probability Phi(-sqrt(2
/// D) / 2); a matched detector with threshold z detects a with probability Phi(sqrt(2 D) - z).
struct Isolability {
  /// Information about log(component) of all pairs at nominal, rows and columns in the
  /// order of the bench.
  Eigen::MatrixXd fisher;
  /// Cosine between the effects of two components: 1 means that small faults look alike.
  Eigen::MatrixXd overlap;
  std::vector<SmallestVisible> smallest;
  std::vector<FaultIsolability> faults;
  /// Components whose small faults have the same effect (overlap 1 up to kSameEffect): no amount of
  /// data of this kind distinguishes them. Components that are alone in their group are left out.
  std::vector<std::vector<Component>> ambiguous;
  double kl_visible_nats = 0.0;    ///< distance at which a fault is `visible`
  double kl_separable_nats = 0.0;  ///< distance at which two faults can be distinguished
};

/// Two components count as different if at least this share of one's effect cannot be explained by
/// the other.
inline constexpr double kSameEffect = 1e-6;

/// Judges a fault set. Deterministic; no noise is simulated. Some 0.2 s for the paper's 18 faults
/// at 100 samples. Refuses (kInvalid, field) options outside the ranges above.
/// Source: Kullback-Leibler distances as Eriksson, Frisk, Krysander, "A method for quantitative
/// fault diagnosability analysis of stochastic linear descriptor models", Automatica 49 (2013).
Result<Isolability> AnalyseIsolability(const IsolabilityOptions& options);

}  // namespace faultlab::core
