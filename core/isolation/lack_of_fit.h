#pragma once

#include <string>

#include "core/isolation/hypothesis.h"

namespace faultlab::core {

/// Whether a fit is the whole truth about the stretch, as far as the stretch can tell.
struct LackOfFit {
  bool adequate = true;
  double score = 0.0;         ///< chi2 / count: 1 is all that noise allows
  bool relaxed = false;       ///< TestRelaxed has run; what follows is known
  double relaxed_gain = 0.0;  ///< cost of the fit minus cost of the relaxed one
  std::string moved;          ///< coordinates that the relaxed fit moved, for a sentence
};

/// Score first; if that is adequate, what relaxed coordinates would gain.
LackOfFit TestLackOfFit(const FitContext& context, const HypothesisFit& fit);
/// chi2 / n <= 1.35 + 5 sqrt(2/n): for a fit that has spent its freedom already.
LackOfFit TestScore(const HypothesisFit& fit);
/// Relaxes the prior of all coordinates around a fit. Not adequate: a gain above 45 (chi-square
/// with about seven degrees of freedom) together with a coordinate that moves by 3 % and five
/// standard errors. A stretch of fewer than 60 readings leaves `judged` as it is.
void TestRelaxed(const FitContext& context, const HypothesisFit& fit, LackOfFit& judged);

}  // namespace faultlab::core
