#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/filter/innovations.h"

namespace faultlab::core {

/// Paths that step together: enough independent chains to hide the latency of the instructions, few
/// enough to stay in the first-level cache.
inline constexpr std::size_t kPathsTogether = 16;

/// What RunInnovations asks for, kPathsTogether paths at a time.
struct LaneRun {
  std::span<const ModelPath> paths;
  std::span<const Observation> stretch;
  std::array<int, kOutputCount> count_of;  ///< readings
  std::span<InnovationSummary> sums;
  double* table = nullptr;  ///< first column of the first row; null: no table is kept
  std::size_t stride = 0;   ///< of its rows
};

/// RunLanes four to a register, on processors that can; false on others. The same bits.
bool RunWideLanes(const LaneRun& run, bool mc_response);

/// Columns of the tables that are summed, padding included.
inline constexpr std::size_t kProductColumns = 12;
using ProductSums = std::array<std::array<double, kProductColumns>, kProductColumns>;

/// Rows of an InnovationTable: neighbours of a point, in column `point` the point itself.
struct ProductRows {
  const double* first = nullptr;
  std::size_t count = 0;
  std::size_t point = 0;
  double per_difference = 0.0;  ///< 1 / how far away the neighbours are
};

/// SumLaneProducts as wide as the processor can.
void SumProducts(const ProductRows& rows, ProductSums& sums);

}  // namespace faultlab::core
