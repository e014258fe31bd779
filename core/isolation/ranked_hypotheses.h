#pragma once

#include <vector>

#include "core/isolation/hypothesis.h"
#include "core/isolation/isolation_options.h"

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

}  // namespace faultlab::core
