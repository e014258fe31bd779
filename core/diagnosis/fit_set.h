#pragma once

#include <string>
#include <vector>

#include "core/diagnosis/hypothesis.h"
#include "core/diagnosis/isolation.h"

namespace faultlab::core {

/// All hypotheses about one stretch, best first.
struct FitSet {
  std::vector<HypothesisFit> fits;  ///< not empty
  bool off_list = false;            ///< relay values were asked for and none of them explains it

  const HypothesisFit& best() const { return fits.front(); }
};

/// What becomes of a hypothesis that cannot win any more: its fit is finished, for whoever wants to
/// see it, or given up where it stands.
enum class Losers { kFitted, kGivenUp };

/// Fits `components` one at a time. Those that one dimension already excludes by a wide margin are
/// not fitted in all.
FitSet FitComponents(const FitContext& context,
                     const std::vector<Component>& components,
                     ValuePrior values,
                     Losers losers);

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
