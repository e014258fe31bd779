#include "core/isolation/ranked_hypotheses.h"

#include <algorithm>
#include <limits>

#include "core/isolation/component_scan.h"

namespace faultlab::core {
namespace {

// A hypothesis is fitted in all coordinates unless its one-dimensional cost is this far above the
// best full fit. The second constant: the uncertainty of the calibration can explain part of a
// misfit, but not twenty times the part that it explains for the best hypothesis.
constexpr double kWorthCost = 300.0;
constexpr double kWorthFactor = 20.0;
constexpr std::size_t kAlwaysFitted = 2;
constexpr double kNever = std::numeric_limits<double>::infinity();
// A relay position is accepted if its cost exceeds that of the free value by less than this.
constexpr double kListedCost = 45.0;

HypothesisFit BestListed(const FitContext& context, Component component) {
  HypothesisFit best;
  const auto& positions = component.info().positions;
  for (std::size_t i = 1; i < positions.size(); ++i) {
    HypothesisFit fit = FitComponentAt(context, component, positions[i].value);
    if (i == 1 || fit.cost < best.cost) best = std::move(fit);
  }
  return best;
}

}  // namespace

RankedHypotheses RankHypotheses(const FitContext& context,
                                const std::vector<Component>& components,
                                ValuePrior values,
                                FitPolicy policy) {
  RankedHypotheses set;
  set.fits = ScanComponents(context, components);
  std::sort(set.fits.begin(), set.fits.end(), LikelierFirst);
  const double best_scan = set.fits.front().cost;
  double best_full = best_scan;
  for (std::size_t i = 0; i < set.fits.size(); ++i) {
    HypothesisFit& fit = set.fits[i];
    const double excess = fit.cost - best_full;
    if (i >= kAlwaysFitted && excess > kWorthCost + kWorthFactor * (best_scan - best_full)) break;
    const bool can_lose = i > 0 && policy == FitPolicy::kStopLosers;
    RefineComponent(context, fit, can_lose ? best_full + kWorthCost : kNever);
    best_full = std::min(best_full, fit.cost);
  }
  std::sort(set.fits.begin(), set.fits.end(), LikelierFirst);

  if (values == ValuePrior::kTable2) {
    std::vector<HypothesisFit> listed;
    for (const HypothesisFit& fit : set.fits) {
      const bool hopeless = fit.cost > set.fits.front().cost + kWorthCost;
      listed.push_back(IsSwitched(fit.component) && !hopeless ? BestListed(context, fit.component)
                                                              : fit);
    }
    std::sort(listed.begin(), listed.end(), LikelierFirst);
    if (listed.front().cost <= set.fits.front().cost + kListedCost) {
      set.fits = std::move(listed);
    } else {
      set.off_list = true;
    }
  }
  return set;
}

}  // namespace faultlab::core
