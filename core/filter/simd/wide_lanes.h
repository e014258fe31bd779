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

/// RunLanes of one path.
void RunAlone(const LaneRun& run, bool mc_response);

/// RunLanes with the widest registers of the processor.
void RunTogether(const LaneRun& run, bool mc_response);

/// Columns of the tables whose products are summed, padding included: enough for a bench whose
/// amplifier's lag is held, and for any.
inline constexpr std::size_t kProductColumns = 12;
inline constexpr std::size_t kProductColumnsMax = 16;
/// The first of the two that holds `n` columns; else the next multiple of the first.
constexpr std::size_t PaddedColumns(std::size_t n) {
  if (n > kProductColumns && n <= kProductColumnsMax) return kProductColumnsMax;
  return (n + kProductColumns - 1) / kProductColumns * kProductColumns;
}
using ProductSums = std::array<std::array<double, kProductColumnsMax>, kProductColumnsMax>;

/// Rows of an InnovationTable: columns of the neighbours, and column `point` of the point itself.
struct ProductRows {
  const double* first = nullptr;
  std::size_t count = 0;
  std::size_t columns = kProductColumns;  ///< or kProductColumnsMax
  std::size_t point = 0;
  double per_difference = 0.0;  ///< 1 / distance of the neighbours from the point
};

/// SumLaneProducts with four lanes to a register on processors that can; returns false on others.
bool SumWideProducts(const ProductRows& rows, ProductSums& sums);

/// SumLaneProducts with the widest registers of the processor.
void SumProducts(const ProductRows& rows, ProductSums& sums);

}  // namespace faultlab::core
