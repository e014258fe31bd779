#include "core/diagnosis/fit_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/diagnosis/component_scan.h"

namespace faultlab::core {
namespace {

// A hypothesis is fitted in all coordinates unless its one-dimensional cost is this far above the
// best full fit: the calibration's uncertainty can explain part of a misfit, not twenty times the
// part that it explains for the best.
constexpr double kWorthCost = 300.0;
constexpr double kWorthFactor = 20.0;
constexpr std::size_t kAlwaysFitted = 2;
constexpr double kNever = std::numeric_limits<double>::infinity();
// A relay position must be as good as the free value, up to this.
constexpr double kListedCost = 45.0;

// What the freed coordinates may gain when the hypothesis is right: chi-square with about seven
// degrees of freedom (99.9999 % at 41), and what the model leaves out.
constexpr double kFreeGainMax = 45.0;
// A second change below this share is the calibration's error, not a fault.
constexpr double kFreeShareMin = 0.03;
constexpr double kFreeSigmas = 5.0;
// chi2/n: noise levels are known to some percent, readings are finite in number.
constexpr double kScoreMargin = 1.35;
constexpr double kScoreSigmas = 5.0;
constexpr int kCountForJudgement = 60;

HypothesisFit BestListed(const FitContext& context, Component component) {
  HypothesisFit best;
  const auto& values = RelayValues(component);
  for (std::size_t i = 1; i < values.size(); ++i) {
    HypothesisFit fit = FitComponentAt(context, component, values[i]);
    if (i == 1 || fit.cost < best.cost) best = std::move(fit);
  }
  return best;
}

}  // namespace

FitSet FitComponents(const FitContext& context,
                     const std::vector<Component>& components,
                     ValuePrior values,
                     Losers losers) {
  FitSet set;
  set.fits = ScanComponents(context, components);
  std::sort(set.fits.begin(), set.fits.end(), LikelierFirst);
  const double best_scan = set.fits.front().cost;
  double best_full = best_scan;
  for (std::size_t i = 0; i < set.fits.size(); ++i) {
    HypothesisFit& fit = set.fits[i];
    const double excess = fit.cost - best_full;
    if (i >= kAlwaysFitted && excess > kWorthCost + kWorthFactor * (best_scan - best_full)) break;
    const bool can_lose = i > 0 && losers == Losers::kGivenUp;
    RefineComponent(context, fit, can_lose ? best_full + kWorthCost : kNever);
    best_full = std::min(best_full, fit.cost);
  }
  std::sort(set.fits.begin(), set.fits.end(), LikelierFirst);

  if (values == ValuePrior::kTable2) {
    std::vector<HypothesisFit> listed;
    for (const HypothesisFit& fit : set.fits) {
      const bool hopeless = fit.cost > set.fits.front().cost + kWorthCost;
      listed.push_back(
          IsRelaySwitched(fit.component) && !hopeless ? BestListed(context, fit.component) : fit);
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

Adequacy JudgeScore(const HypothesisFit& fit) {
  Adequacy judged;
  const double n = std::max(1, fit.count);
  judged.score = fit.chi2 / n;
  judged.adequate = judged.score <= kScoreMargin + kScoreSigmas * std::sqrt(2.0 / n);
  return judged;
}

void SetFree(const FitContext& context, const HypothesisFit& fit, Adequacy& judged) {
  constexpr std::array<const char*, kCoordinateCount> kLabels = {
      "the gain", "R1", "Ra", "J", "B", "the motor constant", "the friction torque", "delta"};
  judged.freed = true;
  if (fit.count < kCountForJudgement) return;
  const FreeFit free = FitFree(context, fit);
  judged.free_gain = fit.cost - free.cost;
  for (int i = 0; i < kCoordinateCount; ++i) {
    const double share = std::abs(free.point(i));
    if (share < kFreeSigmas * free.sigma(i) || share < kFreeShareMin) continue;
    if (!judged.moved.empty()) judged.moved += ", ";
    judged.moved += kLabels[static_cast<std::size_t>(i)];
  }
  const bool structural = judged.free_gain > kFreeGainMax && !judged.moved.empty();
  judged.adequate = judged.adequate && !structural;
}

Adequacy Judge(const FitContext& context, const HypothesisFit& fit) {
  Adequacy judged = JudgeScore(fit);
  if (judged.adequate) SetFree(context, fit, judged);
  return judged;
}

}  // namespace faultlab::core
