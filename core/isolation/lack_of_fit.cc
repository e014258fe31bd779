#include "core/isolation/lack_of_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace faultlab::core {
namespace {

// A second change below this share is an error of the calibration, not a fault.
constexpr double kShareMin = 0.03;
constexpr double kSigmas = 5.0;
// Limit of chi2/n: noise levels are known to some percent, and the number of readings is finite.
constexpr double kScoreMargin = 1.35;
constexpr double kScoreSigmas = 5.0;
constexpr int kCountForJudgement = 60;

}  // namespace

bool FitsNoise(double chi2, int count) {
  const double n = std::max(1, count);
  return chi2 / n <= kScoreMargin + kScoreSigmas * std::sqrt(2.0 / n);
}

LackOfFit TestScore(const HypothesisFit& fit) {
  LackOfFit judged;
  judged.score = fit.chi2 / std::max(1, fit.count);
  judged.adequate = FitsNoise(fit.chi2, fit.count);
  return judged;
}

void TestRelaxed(const FitContext& context, const HypothesisFit& fit, LackOfFit& judged) {
  const std::string_view series = context.rig.plant.structure->parameters[kSeries].symbol;
  const std::array<std::string_view, kCoordinateMax> labels = {"the gain",
                                                               series,
                                                               "Ra",
                                                               "J",
                                                               "B",
                                                               "the motor constant",
                                                               "the friction torque",
                                                               "delta",
                                                               "La",
                                                               "the amplifier's lag"};
  judged.relaxed = true;
  if (fit.count < kCountForJudgement) return;
  const RelaxedFit relaxed = FitRelaxed(context, fit);
  judged.relaxed_gain = fit.cost - relaxed.cost;
  const int own =
      fit.component.exists() ? CoordinateOf(fit.component.info(), context.rig.plant) : -1;
  for (int i = 0; i < relaxed.point.size(); ++i) {
    const double share = std::abs(relaxed.point(i));
    if (share < kSigmas * relaxed.sigma(i) || share < kShareMin) continue;
    const auto add = [&](std::string& list) {
      if (!list.empty()) list += ", ";
      list += labels[static_cast<std::size_t>(i)];
    };
    add(judged.moved);
    if (i != own) add(judged.beside);
  }
  const bool structural = judged.relaxed_gain > kRelaxedGainMax && !judged.moved.empty();
  judged.adequate = judged.adequate && !structural;
}

LackOfFit TestLackOfFit(const FitContext& context, const HypothesisFit& fit) {
  LackOfFit judged = TestScore(fit);
  if (judged.adequate) TestRelaxed(context, fit, judged);
  return judged;
}

}  // namespace faultlab::core
