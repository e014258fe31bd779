#include "core/isolation/lack_of_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace faultlab::core {
namespace {

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

}  // namespace

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
