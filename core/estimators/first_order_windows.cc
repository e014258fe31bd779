#include "core/estimators/first_order_windows.h"

#include <limits>

#include "core/estimators/first_order_solve.h"
#include "core/estimators/sliding_least_squares.h"

namespace faultlab::core {
namespace {

constexpr int kParameters = 3;
constexpr std::size_t kRow = 4;
constexpr FirstOrderWindows::Row kNoRow;

}  // namespace

FirstOrderWindows::FirstOrderWindows(const std::array<ExcitationGate<3>, kEstimatorCount>& gates,
                                     const SiaReport<3>& report)
    : report_(report) {
  for (std::size_t at = 0; at < windows_.size(); ++at) {
    Window& window = windows_[at];
    const int size = kEstimatorShapes[at].window_samples;
    window.slots.resize(static_cast<std::size_t>(size));
    window.kinds.resize(static_cast<std::size_t>(size));
    window.unseen = size;
    window.rows_min = RowsMin<kParameters>(size);
    window.gate = gates[at];
    Pair& pair = pairs_[at / 2];
    for (std::size_t i = 0; i < kParameters; ++i) {
      pair.absolute[i][at % 2] = gates[at].absolute[i];
    }
    pair.relative[at % 2] = gates[at].relative;
    estimates_[at].theta.fill(std::numeric_limits<double>::quiet_NaN());
    estimates_[at].sigma.fill(std::numeric_limits<double>::quiet_NaN());
  }
}

void FirstOrderWindows::Push(std::span<const Row> rows,
                             const std::array<std::size_t, kEstimatorCount>& row_of) {
  for (std::size_t pair = 0; pair < kPairs; ++pair) {
    PushPair(pair, rows[row_of[2 * pair]], rows[row_of[2 * pair + 1]]);
    Solve(pair);
  }
}

void FirstOrderWindows::Window::SetKind(RowKind kind) {
  const RowKind leaving = kinds[at];
  kinds[at] = kind;
  invalid += (kind == RowKind::kInvalid) - (leaving == RowKind::kInvalid);
  rows += (kind == RowKind::kValid) - (leaving == RowKind::kValid);
}

void FirstOrderWindows::PushPair(std::size_t pair, const Row& first, const Row& second) {
  Pair& both = pairs_[pair];
  Window& left = windows_[2 * pair];
  Window& right = windows_[2 * pair + 1];
  std::array<double, kRow>& left_slot = left.slots[left.at];
  std::array<double, kRow>& right_slot = right.slots[right.at];
  const Row& left_row = first.kind == RowKind::kValid ? first : kNoRow;
  const Row& right_row = second.kind == RowKind::kValid ? second : kNoRow;
  std::array<Lanes2, kRow> in;
  std::array<Lanes2, kRow> out;
  for (std::size_t i = 0; i < kRow; ++i) {
    in[i] = Lanes2{left_row.value[i], right_row.value[i]};
    out[i] = Lanes2{left_slot[i], right_slot[i]};
  }
  left_slot = left_row.value;
  right_slot = right_row.value;
  std::size_t p = 0;
  for (std::size_t i = 0; i < kRow; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const Lanes2 product = in[i] * in[j];
      both.sums[p] += product - out[i] * out[j];
      both.shadow[p] += product;
      ++p;
    }
  }
  if (first.kind != left.kinds[left.at]) {
    left.SetKind(first.kind);
    both.per_freedom[0] = 1.0 / (left.rows - kParameters);
  }
  if (second.kind != right.kinds[right.at]) {
    right.SetKind(second.kind);
    both.per_freedom[1] = 1.0 / (right.rows - kParameters);
  }
  Advance(2 * pair);
  Advance(2 * pair + 1);
}

void FirstOrderWindows::Solve(std::size_t pair) {
  const Pair& both = pairs_[pair];
  FirstOrderSolution<Lanes2> solution;
  SolveFirstOrder(both.sums.data(), solution);
  const Lanes2 variance = solution.sse * both.per_freedom;
  const std::array<Lanes2, kParameters> sigma = {SquareRoot(variance * solution.inverse[0]),
                                                 SquareRoot(variance * solution.inverse[2]),
                                                 SquareRoot(variance * solution.inverse[5])};
  const auto accepted =
      (sigma[0] <= both.absolute[0] + both.relative * Magnitude(solution.theta[0])) &
      (sigma[1] <= both.absolute[1] + both.relative * Magnitude(solution.theta[1])) &
      (sigma[2] <= both.absolute[2] + both.relative * Magnitude(solution.theta[2]));
  for (std::size_t lane = 0; lane < 2; ++lane) {
    const std::size_t at = 2 * pair + lane;
    const Window& window = windows_[at];
    Estimate<3>& estimate = estimates_[at];
    if (!window.usable()) {
      estimate.sse = 0.0;
      estimate.condition = std::numeric_limits<double>::infinity();
      HoldEstimate(EstimateStatus::kInvalid, estimate);
      continue;
    }
    estimate.sse = solution.sse[lane];
    estimate.condition = solution.condition[lane];
    if (!(estimate.condition < window.gate.condition_max)) {
      HoldEstimate(EstimateStatus::kNotExcited, estimate);
      continue;
    }
    for (std::size_t i = 0; i < kParameters; ++i) {
      estimate.theta[i] = solution.theta[i][lane];
      estimate.sigma[i] = sigma[i][lane];
    }
    bool excited = accepted[lane] != 0;
    if (ReportsExact(at)) {
      std::array<double, PackedSize(kParameters)> inverse;
      for (std::size_t p = 0; p < inverse.size(); ++p) {
        inverse[p] = solution.inverse[p][lane];
      }
      excited = report_.exact.Apply(
                    inverse.data(), variance[lane], estimate.theta.data(), estimate.sigma.data()) &&
                window.gate.Accepts(estimate.theta, estimate.sigma);
    }
    estimate.age_samples = 0;
    estimate.status = excited ? EstimateStatus::kExcited : EstimateStatus::kWeak;
  }
}

void FirstOrderWindows::Advance(std::size_t at) {
  Window& window = windows_[at];
  window.unseen -= window.unseen > 0;
  if (++window.at == window.slots.size()) {
    window.at = 0;
    Pair& pair = pairs_[at / 2];
    for (std::size_t p = 0; p < pair.sums.size(); ++p) {
      pair.sums[p][at % 2] = pair.shadow[p][at % 2];
      pair.shadow[p][at % 2] = 0.0;
    }
  }
}

void FirstOrderWindows::Skip(int samples) {
  for (std::size_t at = 0; at < windows_.size(); ++at) {
    if (samples >= kEstimatorShapes[at].window_samples) {
      Clear(at);
    } else {
      for (int i = 0; i < samples; ++i) {
        Lose(at);
      }
    }
    AgeEstimate(samples, estimates_[at]);
  }
}

void FirstOrderWindows::Lose(std::size_t at) {
  Window& window = windows_[at];
  Pair& pair = pairs_[at / 2];
  std::array<double, kRow>& slot = window.slots[window.at];
  std::size_t p = 0;
  for (std::size_t i = 0; i < kRow; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      // Not p++ inside: g++ 12 evaluates the index of a lane twice.
      pair.sums[p][at % 2] -= slot[i] * slot[j];
      ++p;
    }
  }
  slot = {};
  window.SetKind(RowKind::kEmpty);
  pair.per_freedom[at % 2] = 1.0 / (window.rows - kParameters);
  Advance(at);
}

void FirstOrderWindows::Clear(std::size_t at) {
  Pair& pair = pairs_[at / 2];
  for (std::size_t p = 0; p < pair.sums.size(); ++p) {
    pair.sums[p][at % 2] = pair.shadow[p][at % 2] = 0.0;
  }
  Window& window = windows_[at];
  window.slots.assign(window.slots.size(), {});
  window.kinds.assign(window.kinds.size(), RowKind::kEmpty);
  window.at = 0;
  window.rows = window.invalid = 0;
  window.unseen = static_cast<int>(window.slots.size());
}

}  // namespace faultlab::core
