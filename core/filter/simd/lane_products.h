#pragma once

#include <array>
#include <cstddef>
#include <cstring>

#include "core/filter/simd/lane_model.h"
#include "core/filter/simd/wide_lanes.h"

namespace faultlab::core {

/// Sums of v v' over the rows, with v = (slopes towards the neighbours, the point). Only the upper
/// triangle of the sums is computed. Columns beyond the point are padding.
template <class Lane, std::size_t kColumns>
void SumColumns(const ProductRows& rows, ProductSums& sums) {
  constexpr std::size_t kLanes = kLaneCount<Lane>;
  constexpr std::size_t kParts = kColumns / kLanes;
  std::array<LaneMask<Lane>, kParts> is_point;
  for (std::size_t p = 0; p < kParts; ++p) {
    Lane column{};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      SetLane(column, lane, static_cast<double>(p * kLanes + lane));
    }
    is_point[p] = column == Lane{} + static_cast<double>(rows.point);
  }
  std::array<std::array<Lane, kParts>, kColumns> to{};
  const double* row = rows.first;
  for (std::size_t r = 0; r < rows.count; ++r, row += kColumns) {
    const Lane point = Lane{} + row[rows.point];
    std::array<Lane, kParts> v;
    std::array<double, kColumns> factor;
#pragma GCC unroll 6
    for (std::size_t p = 0; p < kParts; ++p) {
      Lane value;
      std::memcpy(&value, row + p * kLanes, sizeof(Lane));
      v[p] = is_point[p] ? point : (value - point) * rows.per_difference;
      std::memcpy(&factor[p * kLanes], &v[p], sizeof(Lane));
    }
#pragma GCC unroll 12
    for (std::size_t i = 0; i < kColumns; ++i) {
#pragma GCC unroll 6
      for (std::size_t p = i / kLanes; p < kParts; ++p) to[i][p] += v[p] * factor[i];
    }
  }
  for (std::size_t i = 0; i < kColumns; ++i) {
    for (std::size_t j = i; j < kColumns; ++j) {
      sums[i][j] = GetLane(to[i][j / kLanes], j % kLanes);
    }
  }
}

/// Contract: rows.columns is kProductColumns or kProductColumnsMax.
template <class Lane>
void SumLaneProducts(const ProductRows& rows, ProductSums& sums) {
  rows.columns == kProductColumns ? SumColumns<Lane, kProductColumns>(rows, sums)
                                  : SumColumns<Lane, kProductColumnsMax>(rows, sums);
}

}  // namespace faultlab::core
