#pragma once

#include <string>

#include "core/isolation/hypothesis.h"

namespace faultlab::core {

/// Largest gain of the relaxed coordinates when the hypothesis is right: chi-square with about
/// seven degrees of freedom (99.9999 % at 41), plus a margin for model errors.
inline constexpr double kRelaxedGainMax = 45.0;

/// Whether a fit explains all of the stretch, as far as the stretch can show.
struct LackOfFit {
  bool adequate = true;
  double score = 0.0;         ///< chi2 / count; it is 1 when only noise is left
  bool relaxed = false;       ///< TestRelaxed has run; the members below are valid
  double relaxed_gain = 0.0;  ///< cost of the fit minus cost of the relaxed fit
  std::string moved;          ///< coordinates that the relaxed fit moved, as text
  std::string beside;         ///< of these, those that are not the component's own
};

/// chi2 / n <= 1.35 + 5 sqrt(2/n)
bool FitsNoise(double chi2, int count);
/// Tests the score; if that is adequate, also the gain of relaxed coordinates.
LackOfFit TestLackOfFit(const FitContext& context, const HypothesisFit& fit);
/// Adequate if FitsNoise. Used alone for a drift, and for a value that is
/// fitted again to a longer stretch.
LackOfFit TestScore(const HypothesisFit& fit);
/// Relaxes the prior of all coordinates around a fit. Not adequate: a gain above 45 (chi-square
/// with about seven degrees of freedom) together with a coordinate that moves by at least 3 % and
/// five standard errors. With fewer than 60 readings `judged` keeps its result.
void TestRelaxed(const FitContext& context, const HypothesisFit& fit, LackOfFit& judged);

}  // namespace faultlab::core
