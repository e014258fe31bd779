#include "core/diagnosis/innovation_filter.h"

#include <algorithm>
#include <cmath>

#include "core/diagnosis/lane_products.h"
#include "core/diagnosis/lane_run.h"
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

template <bool kMcResponse>
void RunAll(std::span<const ModelPath> paths,
            std::span<const Observation> stretch,
            std::span<InnovationSummary> sums,
            InnovationTable* table) {
  LAB_CHECK(!paths.empty() && sums.size() == paths.size(), paths.size(), sums.size());
  for (ModelPath path : paths) LAB_CHECK(!path.empty() && path.front().from == 0);
  LaneRun run{paths, stretch, CountReadings(stretch), sums};
  if (table != nullptr) {
    constexpr std::size_t kStep = kProductColumns;  // the products of a table take them so
    run.stride = paths.size() == 1 ? 1 : (paths.size() + kStep - 1) / kStep * kStep;
    const Eigen::Index rows = run.count_of[0] + run.count_of[1] + run.count_of[2];
    const auto columns = static_cast<Eigen::Index>(run.stride);
    if (table->rows() != rows || table->cols() != columns) table->setZero(rows, columns);
  }
  if (paths.size() == 1) {
    if (table != nullptr) run.table = table->data();
    RunLanes<double, kMcResponse>(run);
    return;
  }
  for (std::size_t from = 0; from < paths.size(); from += kPathsTogether) {
    const std::size_t n = std::min(kPathsTogether, paths.size() - from);
    run.paths = paths.subspan(from, n);
    run.sums = sums.subspan(from, n);
    if (table != nullptr) run.table = table->data() + from;
    if (!RunWideLanes(run, kMcResponse)) RunLanes<Lanes2, kMcResponse>(run);
  }
}

}  // namespace

void GainRecursion::Restart() {
  p_ = Eigen::Vector4d(kPoleSdV * kPoleSdV,
                       kCurrentSdA * kCurrentSdA,
                       kSpeedSdRadS * kSpeedSdRadS,
                       model_->torque_variance)
           .asDiagonal();
}

// P+ = phi P phi' + Q, kept symmetric.
void GainRecursion::Predict() {
  const Eigen::Matrix4d left = model_->phi * p_;
  p_.noalias() = left * model_->phi.transpose();
  p_(3, 3) += model_->torque_step_variance;
  const Eigen::Matrix4d symmetric = 0.5 * (p_ + p_.transpose());
  p_ = symmetric;
}

double GainRecursion::Correct(int channel, Eigen::Vector4d& gain) {
  const Eigen::Vector4d ph = p_ * model_->c.row(channel).transpose();
  const double s =
      model_->c.row(channel).dot(ph) + model_->reading_variance[static_cast<std::size_t>(channel)];
  gain = ph / s;
  p_.noalias() -= gain * ph.transpose();
  return s;
}

void RunInnovations(std::span<const ModelPath> paths,
                    std::span<const Observation> stretch,
                    std::span<InnovationSummary> sums,
                    InnovationTable* table) {
  RunAll<false>(paths, stretch, sums, table);
}

void RunWithMcResponse(std::span<const ModelPath> paths,
                       std::span<const Observation> stretch,
                       std::span<InnovationSummary> sums) {
  RunAll<true>(paths, stretch, sums, nullptr);
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

ChannelGains Settle(const PredictionModel& model, unsigned mask) {
  ChannelGains settled;
  GainRecursion recursion(model);
  recursion.Restart();
  constexpr int kSteps = 2000;  // 20 s: many times every time constant of the rig
  for (int k = 0; k < kSteps; ++k) {
    recursion.Predict();
    for (int channel = 0; channel < kOutputCount; ++channel) {
      const auto c = static_cast<std::size_t>(channel);
      settled.gain[c].setZero();
      if ((mask & (1U << channel)) == 0U) continue;
      settled.inverse_sd[c] = 1.0 / std::sqrt(recursion.Correct(channel, settled.gain[c]));
    }
  }
  return settled;
}

}  // namespace faultlab::core
