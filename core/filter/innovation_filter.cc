#include "core/filter/innovation_filter.h"

#include <algorithm>
#include <cmath>

#include "core/filter/simd/wide_lanes.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

std::array<int, kOutputCount> CountReadings(std::span<const Observation> stretch) {
  std::array<int, kOutputCount> count{};
  for (const Observation& o : stretch) {
    for (std::size_t c = 0; c < kOutputCount; ++c) count[c] += (o.mask >> c) & 1;
  }
  return count;
}

bool SomeModelSaturates(std::span<const ModelPath> paths) {
  return std::any_of(paths.begin(), paths.end(), [](ModelPath path) {
    return std::any_of(
        path.begin(), path.end(), [](const ModelSegment& s) { return s.model->saturates(); });
  });
}

void RunAll(bool mc_response,
            std::span<const ModelPath> paths,
            std::span<const Observation> stretch,
            std::span<InnovationSummary> sums,
            InnovationTable* table) {
  LAB_CHECK(!paths.empty() && sums.size() == paths.size(), paths.size(), sums.size());
  for (ModelPath path : paths) LAB_CHECK(!path.empty() && path.front().from == 0);
  LaneRun run{paths, stretch, CountReadings(stretch), sums, SomeModelSaturates(paths)};
  if (table != nullptr) {
    run.stride = paths.size() == 1 ? 1 : PaddedColumns(paths.size());
    const Eigen::Index rows = run.count_of[0] + run.count_of[1] + run.count_of[2];
    const auto columns = static_cast<Eigen::Index>(run.stride);
    if (table->rows() != rows || table->cols() != columns) table->setZero(rows, columns);
  }
  if (paths.size() == 1) {
    if (table != nullptr) run.table = table->data();
    RunAlone(run, mc_response);
    return;
  }
  for (std::size_t from = 0; from < paths.size(); from += kPathsTogether) {
    const std::size_t n = std::min(kPathsTogether, paths.size() - from);
    run.paths = paths.subspan(from, n);
    run.sums = sums.subspan(from, n);
    if (table != nullptr) run.table = table->data() + from;
    RunTogether(run, mc_response);
  }
}

}  // namespace

void RunInnovations(std::span<const ModelPath> paths,
                    std::span<const Observation> stretch,
                    std::span<InnovationSummary> sums,
                    InnovationTable* table) {
  RunAll(false, paths, stretch, sums, table);
}

void RunWithMcResponse(std::span<const ModelPath> paths,
                       std::span<const Observation> stretch,
                       std::span<InnovationSummary> sums) {
  RunAll(true, paths, stretch, sums, nullptr);
}

InnovationSummary RunInnovations(ModelPath path,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace) {
  InnovationSummary sum;
  InnovationTable table;
  RunInnovations(std::span<const ModelPath>(&path, 1),
                 stretch,
                 std::span<InnovationSummary>(&sum, 1),
                 trace != nullptr ? &table : nullptr);
  if (trace == nullptr) return sum;
  trace->whitened.assign(stretch.size() * kOutputCount, 0.0);
  const double* next = table.data();
  for (std::size_t k = 0; k < stretch.size(); ++k) {
    for (std::size_t c = 0; c < kOutputCount; ++c) {
      if ((stretch[k].mask & (1U << c)) != 0U) trace->whitened[k * kOutputCount + c] = *next++;
    }
  }
  return sum;
}

InnovationSummary RunInnovations(const PredictionModel& model,
                                 std::span<const Observation> stretch,
                                 InnovationTrace* trace) {
  const ModelSegment only{0, &model};
  return RunInnovations(ModelPath(&only, 1), stretch, trace);
}

std::vector<double> SortedMagnitudes(const InnovationTrace& trace,
                                     std::span<const Observation> stretch,
                                     std::size_t channel) {
  std::vector<double> sizes;
  for (std::size_t k = 0; k < stretch.size(); ++k) {
    if (((stretch[k].mask >> channel) & 1U) == 0U) continue;
    sizes.push_back(std::abs(trace.whitened[k * kOutputCount + channel]));
  }
  std::sort(sizes.begin(), sizes.end());
  return sizes;
}

double RobustSigma(std::span<const double> sorted_magnitudes) {
  constexpr double kPerMedian = 1.4826;
  return kPerMedian * sorted_magnitudes[sorted_magnitudes.size() / 2];
}

}  // namespace faultlab::core
