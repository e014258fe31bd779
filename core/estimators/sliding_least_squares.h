#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/estimators/excitation_gate.h"
#include "core/estimators/normal_equations.h"
#include "core/estimators/sliding_moments.h"
#include "core/types/check.h"
#include "core/types/estimate.h"

namespace faultlab::core {

/// Share of rows that a full window needs before its estimate is given: half of them. With fewer
/// rows the window does not represent the time span in its name.
inline constexpr double kFillMin = 0.5;

/// The smallest number of rows in a window of `slots` that can determine P parameters.
template <int P>
int RowsMin(int slots) {
  return std::max(P + 1, static_cast<int>(std::ceil(kFillMin * slots)));
}

/// Reports theta and its standard errors unchanged from the least squares.
template <int P>
struct ReportAsSolved {
  /// @returns whether every parameter is resolved (here: always)
  bool operator()(const LeastSquaresSolution<P>& solution,
                  double variance,
                  Estimate<P>& estimate) const {
    estimate.theta = solution.theta;
    for (int i = 0; i < P; ++i) {
      estimate.sigma[static_cast<std::size_t>(i)] =
          std::sqrt(variance * solution.inverse[PackedIndex(i, i)]);
    }
    return true;
  }
};

/// Ages an estimate by `samples` more samples since theta was computed.
template <int P>
void AgeEstimate(std::int32_t samples, Estimate<P>& estimate) {
  constexpr std::int32_t kAgeMax = std::numeric_limits<std::int32_t>::max();
  estimate.age_samples =
      estimate.age_samples > kAgeMax - samples ? kAgeMax : estimate.age_samples + samples;
}

/// One more sample without an estimate: theta stays, its age increases, and no error is stated.
template <int P>
void HoldEstimate(EstimateStatus status, Estimate<P>& estimate) {
  estimate.sigma.fill(std::numeric_limits<double>::quiet_NaN());
  estimate.status = status;
  AgeEstimate(1, estimate);
}

/// Least squares over the newest `window` slots.
///   y_k = phi_k' theta + e_k,   k = n-window+1 .. n,   e_k zero-mean, white
/// @param phi  [P]  regressor of this sample
/// Every push returns theta [P], sigma [P] = sqrt(s^2 diag(N^-1)), s^2 = sse / (rows - P), the sse,
/// the condition number (see SolveNormalEquations) and a status:
///   kInvalid:    the window is not full, holds an invalid slot or less than kFillMin of its rows
///   kNotExcited: condition beyond the gate
///   kWeak:       a standard error beyond the gate's tolerance, or a parameter the report could not
///                resolve
///   kExcited:    otherwise
/// In the first two cases theta is the last one computed, sigma is NaN and age_samples is its age;
/// before the first estimate theta is NaN.
/// Throws ContractError if window <= P. No allocation after construction. Not thread-safe.
/// Source: paper Eq. (14)-(16).
template <int P, typename Report = ReportAsSolved<P>>
class SlidingLeastSquares {
 public:
  using Moments = SlidingMoments<P + 1>;
  using Row = typename Moments::Row;  ///< phi_1 .. phi_P, y

  SlidingLeastSquares(int window, const ExcitationGate<P>& gate, const Report& report = Report())
      : moments_(window), gate_(gate), report_(report), rows_min_(RowsMin<P>(window)) {
    LAB_CHECK(window > P, window, P);
    estimate_.theta.fill(std::numeric_limits<double>::quiet_NaN());
    estimate_.sigma.fill(std::numeric_limits<double>::quiet_NaN());
  }

  /// Subtracts `per_row` (packed like the sums) for every valid row before solving. It is the mean
  /// contribution of zero-mean noise of known variance to the sums (bias-compensated least
  /// squares).
  void CompensateNoise(const typename Moments::Packed& per_row) { noise_ = per_row; }

  const Estimate<P>& Push(const Row& row) {
    moments_.Push(row);
    return Update();
  }

  /// A sample without a row: kEmpty or kInvalid.
  const Estimate<P>& PushEmpty(RowKind kind) {
    moments_.PushEmpty(kind);
    return Update();
  }

  /// `samples` were lost; they leave empty slots. The cost does not grow beyond one window.
  void Skip(int samples) {
    if (samples >= moments_.window()) {
      moments_.Clear();
    } else {
      for (int i = 0; i < samples; ++i) {
        moments_.PushEmpty(RowKind::kEmpty);
      }
    }
    AgeEstimate(samples, estimate_);
  }

  const Estimate<P>& estimate() const { return estimate_; }
  const Moments& moments() const { return moments_; }

 private:
  const Estimate<P>& Update() {
    const int rows = moments_.rows();
    if (moments_.invalid() != 0 || !moments_.full() || rows < rows_min_) {
      estimate_.sse = 0.0;
      estimate_.condition = std::numeric_limits<double>::infinity();
      return Hold(EstimateStatus::kInvalid);
    }
    LeastSquaresSolution<P> solution;
    if (noise_) {
      SolveCompensated(rows, solution);
    } else {
      SolveNormalEquations<P>(moments_.sums(), solution);
    }
    estimate_.sse = solution.sse;
    estimate_.condition = solution.condition;
    if (!(solution.condition < gate_.condition_max)) {
      return Hold(EstimateStatus::kNotExcited);
    }
    if (rows != scaled_rows_) {
      scaled_rows_ = rows;
      per_freedom_ = 1.0 / (rows - P);
    }
    const bool resolved = report_(solution, solution.sse * per_freedom_, estimate_);
    estimate_.age_samples = 0;
    estimate_.status = resolved && gate_.Accepts(estimate_.theta, estimate_.sigma)
                           ? EstimateStatus::kExcited
                           : EstimateStatus::kWeak;
    return estimate_;
  }

  const Estimate<P>& Hold(EstimateStatus status) {
    HoldEstimate(status, estimate_);
    return estimate_;
  }

  void SolveCompensated(int rows, LeastSquaresSolution<P>& solution) const {
    const typename Moments::Packed& sums = moments_.sums();
    typename Moments::Packed compensated = sums;
    for (std::size_t p = 0; p < compensated.size(); ++p) {
      compensated[p] -= rows * (*noise_)[p];
    }
    SolveNormalEquations<P>(compensated, solution);
    if (!std::isfinite(solution.condition)) {
      return;  // a pivot vanished: there is no theta
    }
    // The squared residuals of this theta, noise included: c' S c with c = [theta, -1].
    double sse = sums[PackedIndex(P, P)];
    for (int i = 0; i < P; ++i) {
      const double theta_i = solution.theta[static_cast<std::size_t>(i)];
      sse += theta_i * (theta_i * sums[PackedIndex(i, i)] - 2.0 * sums[PackedIndex(P, i)]);
      for (int j = 0; j < i; ++j) {
        sse +=
            2.0 * theta_i * solution.theta[static_cast<std::size_t>(j)] * sums[PackedIndex(i, j)];
      }
    }
    solution.sse = sse > 0.0 ? sse : 0.0;
  }

  Moments moments_;
  ExcitationGate<P> gate_;
  Report report_;
  std::optional<typename Moments::Packed> noise_;
  Estimate<P> estimate_;
  int rows_min_;              ///< fewer make the window invalid
  int scaled_rows_ = 0;       ///< the rows that per_freedom_ was computed for
  double per_freedom_ = 0.0;  ///< 1 / (rows - P)
};

}  // namespace faultlab::core
