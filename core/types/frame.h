#pragma once

#include <array>
#include <string_view>

#include "core/types/estimate.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// The six first-order estimators that run at every sample (paper sections 3.1.2 and 3.1.3).
enum class EstimatorId { kSwa50, kSwa100, kSwa200, kSia20x5, kSia100x20, kSia500x20 };

inline constexpr int kEstimatorCount = 6;

struct EstimatorShape {
  std::string_view name;
  int window_samples;    ///< K, rows of the least squares
  int integral_samples;  ///< m of the sliding integral, 0 for SWA
};

inline constexpr std::array<EstimatorShape, kEstimatorCount> kEstimatorShapes = {
    {{"swa_50", 50, 0},
     {"swa_100", 100, 0},
     {"swa_200", 200, 0},
     {"sia_20_5", 20, 5},
     {"sia_100_20", 100, 20},
     {"sia_500_20", 500, 20}}};

/// A sample with the estimates up to it: SWA theta = {b0d, b1d, a1d}, SIA theta = {b0, b1, a1}.
struct Frame {
  Sample sample;
  std::array<Estimate<3>, kEstimatorCount> estimates;
};

}  // namespace faultlab::core
