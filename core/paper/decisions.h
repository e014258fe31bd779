#pragma once

#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/paper/theta.h"
#include "core/types/component.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// One place of the paper's decision algorithm (Fig. 21): a question, or an end of it.
struct Decision {
  std::string_view question;  ///< "b0 outside its band?"; empty: an end
  int yes = -1;               ///< place of the next one, -1 at an end
  int no = -1;
  bool healthy = false;               ///< this end says that nothing has changed
  std::vector<Component> components;  ///< that are possible here, in the order of the bench
};

/// The algorithm belongs to the paper's structure, and its thresholds to a bench that a publication
/// describes: others have none.
bool HasDecisions(const Bench& bench);

/// All of it, the first question first. Contract: HasDecisions(bench).
std::vector<Decision> DecisionsOf(const Bench& bench);

/// The way that an estimate takes through it, to an end.
/// @param band  half width of each coefficient's band (> 0)
std::vector<PathStep> FollowDecisions(const Bench& bench,
                                      const ContinuousTheta& nominal,
                                      const ContinuousTheta& estimate,
                                      const ContinuousTheta& band);

}  // namespace faultlab::core
