#pragma once

#include <span>
#include <vector>

#include "core/isolation/hypothesis.h"

namespace faultlab::core {

/// Looks for the value of each of `components` along its whole range: one dimension, the
/// calibration's coordinates held (Mc apart, which enters linearly). Costs and values are rough.
std::vector<HypothesisFit> ScanComponents(const FitContext& context,
                                          std::span<const Component> components);

}  // namespace faultlab::core
