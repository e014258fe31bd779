#pragma once

#include <string>
#include <vector>

#include "core/diagnosis/hypothesis.h"
#include "core/diagnosis/isolation.h"

namespace faultlab::core {

/// All hypotheses about one stretch, best first.
struct FitSet {
  std::vector<HypothesisFit> fits;  ///< not empty
  HypothesisFit nothing;            ///< the stretch without a new fault
  bool off_list = false;            ///< relay values were asked for and none of them explains it

  const HypothesisFit& best() const { return fits.front(); }
  double gain() const { return nothing.cost - best().cost; }
};

/// Fits `components` one at a time. Those that one dimension already excludes by a wide margin are
/// not fitted in all.
FitSet FitComponents(const FitContext& context,
                     const std::vector<Component>& components,
                     ValuePrior values);

/// Whether a fit is the whole truth about the stretch, as far as the stretch can tell.
struct Adequacy {
  bool adequate = true;
  double score = 0.0;      ///< chi2 over its expectation
  double free_gain = 0.0;  ///< what setting all coordinates free would gain
  std::string moved;       ///< which of them would go where, for a sentence
};
Adequacy Judge(const FitContext& context, const HypothesisFit& fit);
/// By the score alone, for a fit that has spent its freedom already.
Adequacy JudgeScore(const HypothesisFit& fit);

}  // namespace faultlab::core
