#include "core/diagnosis/innovation_filter.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/diagnosis/lane_filter.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

// Filters that step together: enough to hide each other's latency, few enough for the first cache.
constexpr std::size_t kTogether = 8;

std::array<int, kOutputCount> CountReadings(std::span<const Observation> stretch) {
  std::array<int, kOutputCount> count{};
  for (const Observation& o : stretch) {
    for (std::size_t c = 0; c < kOutputCount; ++c) count[c] += (o.mask >> c) & 1;
  }
  return count;
}

// Rows of an InnovationTable as the filters write them.
struct TableRows {
  double* next = nullptr;  ///< first column of the next row; null: nothing is kept
  std::size_t stride = 0;
};

// At most kTogether * kLaneCount paths. Lanes beyond the paths repeat the last one.
template <class Lane, bool kMcResponse>
void RunTogether(std::span<const ModelPath> paths,
                 std::span<const Observation> stretch,
                 const std::array<int, kOutputCount>& count_of,
                 std::span<InnovationSummary> sums,
                 TableRows rows) {
  constexpr std::size_t kLanes = kLaneCount<Lane>;
  constexpr std::size_t kNever = std::numeric_limits<std::size_t>::max();
  const std::size_t filter_count = (paths.size() + kLanes - 1) / kLanes;
  std::array<LaneFilter<Lane, kMcResponse>, kTogether> filters;
  std::array<std::size_t, kTogether * kLanes> segment{};  // that is next, for each lane
  std::size_t next_switch = 0;
  std::array<Lane, kOutputCount> z{};
  for (std::size_t k = 0; k < stretch.size(); ++k) {
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
    const Observation& now = stretch[k];
    for (std::size_t f = 0; f < filter_count; ++f) {
      filters[f].Step(now, z);
      if (rows.next == nullptr) continue;
      double* to = rows.next + f * kLanes;
      for (std::size_t c = 0; c < kOutputCount; ++c) {
        if ((now.mask & (1U << c)) == 0U) continue;
        std::memcpy(to, &z[c], sizeof(Lane));
        to += rows.stride;
      }
    }
    if (rows.next != nullptr) {
      for (std::size_t c = 0; c < kOutputCount; ++c)
        rows.next += ((now.mask >> c) & 1U) * rows.stride;
    }
  }
  for (std::size_t i = 0; i < paths.size(); ++i) {
    sums[i] = filters[i / kLanes].Summary(i % kLanes, count_of);
  }
}

template <bool kMcResponse>
void RunAll(std::span<const ModelPath> paths,
            std::span<const Observation> stretch,
            std::span<InnovationSummary> sums,
            InnovationTable* table) {
  LAB_CHECK(!paths.empty() && sums.size() == paths.size(), paths.size(), sums.size());
  for (ModelPath path : paths) LAB_CHECK(!path.empty() && path.front().from == 0);
  const std::array<int, kOutputCount> count_of = CountReadings(stretch);
  TableRows rows;
  if (table != nullptr) {
    rows.stride = paths.size() == 1 ? 1 : (paths.size() + 1) / 2 * 2;
    table->resize(count_of[0] + count_of[1] + count_of[2], static_cast<Eigen::Index>(rows.stride));
    rows.next = table->data();
  }
  if (paths.size() == 1) {
    RunTogether<double, kMcResponse>(paths, stretch, count_of, sums, rows);
    return;
  }
  constexpr std::size_t kChunk = kTogether * kLaneCount<Lanes2>;
  for (std::size_t from = 0; from < paths.size(); from += kChunk) {
    const std::size_t n = std::min(kChunk, paths.size() - from);
    RunTogether<Lanes2, kMcResponse>(
        paths.subspan(from, n), stretch, count_of, sums.subspan(from, n), rows);
    if (rows.next != nullptr) rows.next += n;
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
