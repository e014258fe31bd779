#pragma once

#include <Eigen/Core>
#include <limits>

#include "core/isolation/fit_context.h"

namespace faultlab::core {

/// One component alone has changed: what it must be, and how well that explains the stretch.
struct HypothesisFit {
  Component component = Component::kR1;
  bool exists = false;  ///< false: no value of it comes near
  double value = 0.0;
  double log_sigma = 0.0;  ///< standard error of log(value), calibration's uncertainty included
  char bound = 0;          ///< '<' or '>': only a bound can be told
  double chi2 = 0.0;
  int count = 0;
  double cost = 0.0;  ///< -2 log posterior, up to what all hypotheses share
  /// What the size of the change costs: weak, it only orders what the data do not.
  double size_cost = 0.0;
  Eigen::VectorXd nuisance;  ///< the eight coordinates, as the fit moved them

  double rank_cost() const { return cost + size_cost; }
};

inline bool LikelierFirst(const HypothesisFit& a, const HypothesisFit& b) {
  return a.rank_cost() < b.rank_cost();
}

/// (log of the change / log 10)^2: a part is rather ten times off than a hundred times.
double SizeCost(const PlantParameters& plant, Component component, double value);

/// The stretch under the rig as it is, nuisances fitted.
HypothesisFit FitNothing(const FitContext& context);

/// Fits value and the calibration's coordinates together under the calibration's posterior, from
/// what a scan found; tells a bound when the value is not determined. A fit that cannot come below
/// `give_up_above` is left where that is seen.
void RefineComponent(const FitContext& context,
                     HypothesisFit& fit,
                     double give_up_above = std::numeric_limits<double>::infinity());

/// The same at one given value (a relay position): nothing is scanned.
HypothesisFit FitComponentAt(const FitContext& context, Component component, double value);

/// A value that moves linearly through the stretch.
struct DriftFit {
  double first_value = 0.0;  ///< at the beginning of the stretch
  HypothesisFit fit;         ///< value: at its end
};
DriftFit FitDrift(const FitContext& context, const HypothesisFit& from);

/// What the stretch prefers when all coordinates are set free around a hypothesis: its cost, and
/// how far the coordinates went. A hypothesis that leaves much to gain here is not the whole truth.
struct FreeFit {
  double cost = 0.0;
  Eigen::VectorXd point;  ///< the eight coordinates
  Eigen::VectorXd sigma;
};
FreeFit FitFree(const FitContext& context, const HypothesisFit& from);

/// Sum over the stretch of the squared difference between two hypotheses' whitened predictions,
/// per sample: zero if no amount of data of this kind can tell them apart.
double PredictionDistance(const FitContext& context,
                          const HypothesisFit& a,
                          const HypothesisFit& b);

}  // namespace faultlab::core
