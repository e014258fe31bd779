#pragma once

#include <Eigen/Core>
#include <limits>

#include "core/isolation/fit_context.h"

namespace faultlab::core {

/// One component alone has changed: what it must be, and how well that explains the stretch. With
/// theta its value, q the eight coordinates of the calibration (nuisances) and z the whitened
/// innovations under both,
///   cost = min over (log theta, q) of  sum z^2 + sum log S + (q - mean)' information (q - mean)
/// which is -2 log posterior, up to a constant that all hypotheses about one stretch share. A cost
/// is free of units; a difference of 9 is three standard deviations.
struct HypothesisFit {
  Component component = Component::kR1;
  bool exists = false;     ///< false: no value of it comes near
  double value = 0.0;      ///< SI unit of the component
  double log_sigma = 0.0;  ///< standard error of log(value), calibration's uncertainty included
  char bound = 0;          ///< '<' or '>': only a bound can be told
  double chi2 = 0.0;       ///< sum z^2; expectation `count` when the hypothesis is true
  int count = 0;           ///< scalar readings
  double cost = 0.0;
  double magnitude_cost = 0.0;  ///< MagnitudePrior: weak, it only orders what the data do not
  Eigen::VectorXd nuisance;     ///< [8] the coordinates, as the fit moved them

  double rank_cost() const { return cost + magnitude_cost; }
};

inline bool LikelierFirst(const HypothesisFit& a, const HypothesisFit& b) {
  return a.rank_cost() < b.rank_cost();
}

/// (log10(value / nominal))^2, added to a cost: a part is rather ten times off than a hundred
/// times. C8 counts from 1 uF, the least that shows.
double MagnitudePrior(const PlantParameters& plant, Component component, double value);

/// H0: the stretch under the rig as it is, nuisances fitted.
HypothesisFit FitNullHypothesis(const FitContext& context);

/// Fits value and the calibration's coordinates together under the calibration's posterior, from
/// what a scan found in `fit` (component, value). A value whose cost rises by less than 9 all the
/// way to one end of its range is told as a bound, where the rise is 9. A fit that cannot come
/// below `give_up_above` is left where that is seen: its cost is then too high, and its value
/// rough.
void RefineComponent(const FitContext& context,
                     HypothesisFit& fit,
                     double give_up_above = std::numeric_limits<double>::infinity());

/// The same at one given value (a relay position): nothing is scanned, log_sigma is 0.
HypothesisFit FitComponentAt(const FitContext& context, Component component, double value);

/// A value that moves linearly through the stretch, in steps of ten samples.
struct DriftFit {
  double first_value = 0.0;  ///< at the beginning of the stretch, SI unit
  HypothesisFit fit;         ///< value: at its end
};
/// @param from  a fitted hypothesis: both ends start at its value
DriftFit FitDrift(const FitContext& context, const HypothesisFit& from);

/// What the stretch prefers when the prior of all coordinates is relaxed (to a factor of e) around
/// a hypothesis. One that leaves much to gain here is not the whole truth.
struct RelaxedFit {
  double cost = 0.0;      ///< sum z^2 + sum log S, no prior: compare with HypothesisFit::cost
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
