#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/isolation/fit_context.h"
#include "core/types/speed_response.h"

namespace faultlab::core {

/// Prior of the logarithm of a value, around that of the scan: one standard deviation. Almost flat;
/// the little information it has keeps matrices regular when a cost is flat.
inline constexpr double kValueLogSd = 4.0;

/// The hypothesis that one component alone has changed: its most likely value, and how well it
/// explains the stretch. With theta the value, q the eight coordinates of the calibration
/// (nuisances) and z the whitened innovations under both,
///   cost = min over (log theta, q) of  sum z^2 + sum log S + (q - mean)' information (q - mean)
/// which is -2 log posterior, up to a constant that all hypotheses about one stretch share. A cost
/// has no unit; a difference of 9 is three standard deviations.
struct HypothesisFit {
  Component component{};
  bool exists = false;     ///< false: no value of the component comes near
  double value = 0.0;      ///< SI unit of the component
  double log_sigma = 0.0;  ///< standard error of log(value), calibration's included
  char bound = 0;          ///< '<' or '>': only a bound is known
  double chi2 = 0.0;       ///< sum z^2; expectation `count` when the hypothesis is true
  int count = 0;           ///< scalar readings
  double cost = 0.0;
  double magnitude_cost = 0.0;  ///< MagnitudePrior: weak, it decides only where the data do not
  Eigen::VectorXd nuisance;     ///< [8] the coordinates of this fit
  std::optional<SpeedResponse> response{};  ///< of the rig with the fault, if the speed is all

  /// -2 log of the hypothesis' probability, by Laplace's approximation: the prior of a value is as
  /// wide for each component, that of a listed one a third of it.
  double rank_cost() const {
    constexpr double kWidest = 2.3;  // of the logarithm of a value, a decade
    const double sd = !std::isfinite(log_sigma) ? kWidest
                      : log_sigma == 0.0        ? kWidest / 3.0
                                                : std::clamp(log_sigma, 1e-9, kWidest);
    return cost + magnitude_cost - 2.0 * std::log(sd);
  }
};

inline bool LikelierFirst(const HypothesisFit& a, const HypothesisFit& b) {
  return a.rank_cost() < b.rank_cost();
}

/// (log10(value / nominal))^2, added to a cost: a change by a factor of ten is more likely than one
/// by a hundred. C8 counts from 1 uF, its least visible value.
double MagnitudePrior(const PlantParameters& plant, Component component, double value);

/// H0: the stretch under the unchanged rig, with the nuisances fitted.
HypothesisFit FitNullHypothesis(const FitContext& context);

/// Fits the value together with the calibration's coordinates under the calibration's posterior.
/// `fit` (component, value) is the start, from a scan. If the cost rises by less than 9 all the way
/// to one end of the range, the result is a bound, at the value where the rise is 9. A fit that
/// cannot come below `give_up_above` is stopped as soon as this is known: its cost is then too high
/// and its value rough.
void RefineComponent(const FitContext& context,
                     HypothesisFit& fit,
                     double give_up_above = std::numeric_limits<double>::infinity());

/// The same for one given value (a relay position): no scan, and log_sigma is 0.
HypothesisFit FitComponentAt(const FitContext& context, Component component, double value);

/// Samples (SpanOf) for which a drifting value is held constant. A slow one shows no finer steps.
inline constexpr std::size_t kDriftBlock = 10;

/// A value that changes linearly through the stretch, in steps of a block.
struct DriftFit {
  double first_value = 0.0;  ///< at the beginning of the stretch, SI unit
  HypothesisFit fit;         ///< fit.value: at the end of the stretch
};
/// @param from   a fitted hypothesis, whose value is the start for both ends
/// @param block  samples (SpanOf)
DriftFit FitDrift(const FitContext& context,
                  const HypothesisFit& from,
                  std::size_t block = kDriftBlock);

/// The best fit when the prior of all coordinates is relaxed (to a factor of e) around a
/// hypothesis. If this lowers the cost much, the hypothesis does not explain everything.
struct RelaxedFit {
  double cost = 0.0;      ///< sum z^2 + sum log S, without prior
  Eigen::VectorXd point;  ///< [8]
  Eigen::VectorXd sigma;  ///< [8]
};
RelaxedFit FitRelaxed(const FitContext& context, const HypothesisFit& from);

/// 1/n sum over the stretch of |za - zb|^2, the squared difference between the whitened innovations
/// of two hypotheses, per sample: zero if no amount of data of this kind can tell them apart.
double PredictionDistance(const FitContext& context,
                          const HypothesisFit& a,
                          const HypothesisFit& b);

}  // namespace faultlab::core
