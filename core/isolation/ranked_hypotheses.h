#pragma once

#include <vector>

#include "core/isolation/hypothesis.h"
#include "core/isolation/isolation_options.h"

namespace faultlab::core {

/// All hypotheses about one stretch, best first.
struct RankedHypotheses {
  std::vector<HypothesisFit> fits;  ///< not empty
  bool off_list = false;            ///< only relay values were allowed, and none fits

  const HypothesisFit& best() const { return fits.front(); }
};

/// How a hypothesis that cannot win any more is treated: its fit is finished (for display), or
/// stopped as soon as this is known.
enum class FitPolicy { kFitAll, kStopLosers };

/// Fits `components` one at a time and sorts them by rank_cost. A component whose profile cost is
/// 300 + 20 (best profile cost - best full cost) above the best keeps the values of its scan; the
/// two best are always fitted. With ValuePrior::kTable2 a relay's component takes the best of its
/// listed values, unless no listed one comes within 45 of the best free value: then `off_list`.
/// Contract: at least one component.
RankedHypotheses RankHypotheses(const FitContext& context,
                                const std::vector<Component>& components,
                                ValuePrior values,
                                FitPolicy policy);

}  // namespace faultlab::core
