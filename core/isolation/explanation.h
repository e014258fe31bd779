#pragma once

#include <optional>
#include <vector>

#include "core/isolation/clean_readings.h"
#include "core/isolation/fault_shape.h"
#include "core/isolation/fit_context.h"
#include "core/isolation/isolation_task.h"
#include "core/isolation/lack_of_fit.h"
#include "core/isolation/outside_hypotheses.h"
#include "core/isolation/ranked_hypotheses.h"

namespace faultlab::core {

/// Gain in -2 log p over "nothing changed" that a fault needs; it includes the choice among all
/// faults.
inline constexpr double kFaultGain = 14.0;
/// Hypotheses within this cost of the best one are not excluded: three standard deviations.
inline constexpr double kNotExcludedCost = 9.0;

/// One answer about the stretch after the alarm.
struct Explanation {
  FitContext context;
  RankedHypotheses set;
  LackOfFit lack_of_fit;
  FaultShape shape = FaultShape::kAbrupt;
  HypothesisFit null{};  ///< the same stretch without a new fault
  /// Fits, and is not excluded beside the best component: within kNotExcludedCost of it, or better.
  std::optional<OutsideFit> outside{};
  bool is_outside = false;  ///< `outside` leaves no component
  double gain = 0.0;        ///< of cost, compared with the same stretch without a new fault
  double rate = 0.0;        ///< of a drift that goes on: SI units of the component a second
  std::optional<HypothesisFit> of_newest{};  ///< what came nearest to the newest kLateSamples
};

/// Tries one value for the whole stretch; then one value for its newest part; then a slope.
/// @param components  one of which has changed
Explanation Explain(const FitContext& context,
                    const std::vector<Component>& components,
                    const IsolationTask& task,
                    CleanReadings& readings);

/// Tries a slope for 0.4 s, or one value at its end. So little is explained by many a value: that
/// of `component`, which comes nearest to the whole stretch, must explain it best.
std::optional<Explanation> ExplainSteep(const FitContext& context,
                                        const std::vector<Component>& components,
                                        const IsolationTask& task,
                                        CleanReadings& readings,
                                        Component component);

}  // namespace faultlab::core
