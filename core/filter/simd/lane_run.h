#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <span>

#include "core/filter/simd/lane_filter.h"
#include "core/filter/simd/wide_lanes.h"

namespace faultlab::core {

/// RunLanes, compiled for models that saturate and for models that do not.
template <class Lane, bool kMcResponse, bool kSaturates>
void RunFilters(const LaneRun& run) {
  constexpr std::size_t kLanes = kLaneCount<Lane>;
  constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();
  const std::span<const ModelPath> paths = run.paths;
  const std::size_t filter_count = (paths.size() + kLanes - 1) / kLanes;
  std::array<LaneFilter<Lane, kMcResponse, kSaturates>, kPathsTogether / kLanes> filters;
  std::array<std::size_t, kPathsTogether> segment{};  // the next segment of each lane
  std::size_t next_switch = 0;
  std::array<Lane, kOutputCount> z{};
  double* row = run.table;
  for (std::size_t k = 0; k < run.stretch.size(); ++k) {
    if (k == next_switch) {
      next_switch = kNever;
      for (std::size_t lane = 0; lane < filter_count * kLanes; ++lane) {
        const ModelPath path = paths[std::min(lane, paths.size() - 1)];
        std::size_t& next = segment[lane];
        if (next < path.size() && path[next].from == k) {
          filters[lane / kLanes].SetModel(lane % kLanes, *path[next].model, path[next].uncharged);
          ++next;
        }
        if (next < path.size()) next_switch = std::min(next_switch, path[next].from);
      }
    }
    const Observation& now = run.stretch[k];
    for (std::size_t f = 0; f < filter_count; ++f) {
      filters[f].Step(now, z);
      if (row == nullptr) continue;
      double* to = row + f * kLanes;
      for (std::size_t c = 0; c < kOutputCount; ++c) {
        if ((now.mask & (1U << c)) == 0U) continue;
        std::memcpy(to, &z[c], sizeof(Lane));
        to += run.stride;
      }
    }
    if (row == nullptr) continue;
    for (std::size_t c = 0; c < kOutputCount; ++c) row += ((now.mask >> c) & 1U) * run.stride;
  }
  for (std::size_t i = 0; i < paths.size(); ++i) {
    run.sums[i] = filters[i / kLanes].Summary(i % kLanes, run.count_of);
  }
}

/// Lanes beyond the paths repeat the last one.
template <class Lane, bool kMcResponse>
void RunLanes(const LaneRun& run) {
  run.saturates ? RunFilters<Lane, kMcResponse, true>(run)
                : RunFilters<Lane, kMcResponse, false>(run);
}

}  // namespace faultlab::core
