#pragma once

#include <span>
#include <vector>

#include "core/isolation/hypothesis.h"

namespace faultlab::core {

/// For each of `components`, in their order, the value with the lowest ProfileCost over its whole
/// range: a scan on the first 120 samples, then a golden section of twelve steps on the first 300.
/// cost, chi2 and count are over the whole stretch, log_sigma is NaN, nuisance is the calibration's
/// mean. The result is a start for RefineComponent. If a cost has several valleys, the one around
/// the best point of the scan is taken. A component whose predictions are not finite has the
/// largest double as cost.
std::vector<HypothesisFit> ScanComponents(const FitContext& context,
                                          std::span<const Component> components);

}  // namespace faultlab::core
