#pragma once

#include <span>
#include <vector>

#include "core/isolation/hypothesis.h"

namespace faultlab::core {

/// The value of each of `components` that ProfileCost is lowest at, over its whole range: a scan on
/// the first 120 samples, then a golden section of twelve steps on the first 300. One fit for each
/// component, in their order; cost, chi2 and count are over the whole stretch, log_sigma is NaN,
/// nuisance the calibration's mean. A start for RefineComponent: where a cost has several valleys,
/// the one around the best point of the scan is taken. A component that predicts nothing finite has
/// the largest double as cost.
std::vector<HypothesisFit> ScanComponents(const FitContext& context,
                                          std::span<const Component> components);

}  // namespace faultlab::core
