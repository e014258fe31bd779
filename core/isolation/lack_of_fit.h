#pragma once

#include <string>

#include "core/isolation/hypothesis.h"

namespace faultlab::core {

/// Whether a fit is the whole truth about the stretch, as far as the stretch can tell.
struct Adequacy {
  bool adequate = true;
  double score = 0.0;      ///< chi2 over its expectation
  bool freed = false;      ///< all coordinates were set free; what follows is known
  double free_gain = 0.0;  ///< what that would gain
  std::string moved;       ///< which of them would go where, for a sentence
};
/// By the score, and if that is good, by what freedom would gain.
Adequacy Judge(const FitContext& context, const HypothesisFit& fit);
/// By the score alone, for a fit that has spent its freedom already.
Adequacy JudgeScore(const HypothesisFit& fit);
/// Sets all coordinates free around a fit; a stretch of few readings tells nothing by that.
void SetFree(const FitContext& context, const HypothesisFit& fit, Adequacy& judged);

}  // namespace faultlab::core
