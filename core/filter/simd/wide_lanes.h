#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/filter/innovations.h"

namespace faultlab::core {

/// Paths that step together: enough independent chains to hide the instruction latency, few enough
/// to fit the first-level cache.
inline constexpr std::size_t kPathsTogether = 16;

/// The request of RunInnovations, at most kPathsTogether paths at a time.
struct LaneRun {
  std::span<const ModelPath> paths;
  std::span<const Observation> stretch;
  std::array<int, kOutputCount> count_of;  ///< readings
  std::span<InnovationSummary> sums;
  bool saturates;           ///< some model of the paths does
  double* table = nullptr;  ///< first column of the first row; null: no table is kept
  std::size_t stride = 0;   ///< of its rows
};

/// RunLanes with four lanes to a register on processors that can; returns false on others. The bits
/// are the same.
bool RunWideLanes(const LaneRun& run, bool mc_response);

/// Columns of the tables whose products are summed, padding included.
inline constexpr std::size_t kProductColumns = 12;
using ProductSums = std::array<std::array<double, kProductColumns>, kProductColumns>;

/// Rows of an InnovationTable: columns of the neighbours, and column `point` of the point itself.
struct ProductRows {
  const double* first = nullptr;
  std::size_t count = 0;
  std::size_t point = 0;
  double per_difference = 0.0;  ///< 1 / distance of the neighbours from the point
};

/// SumLaneProducts with four lanes to a register on processors that can; returns false on others.
bool SumWideProducts(const ProductRows& rows, ProductSums& sums);

/// SumLaneProducts with the widest registers of the processor.
void SumProducts(const ProductRows& rows, ProductSums& sums);

}  // namespace faultlab::core
