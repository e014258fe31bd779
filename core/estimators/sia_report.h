#pragma once

#include "core/estimators/sia_mode.h"
#include "core/estimators/sliding_least_squares.h"

namespace faultlab::core {

/// Inverts the rectangular rule for a piecewise constant input and gives {b0, b1, a1} (see
/// SiaMode::kExact), with first-order standard errors from the full covariance of theta'. If a1' is
/// at most T, sampling at T does not resolve the time constant: then a1 = b1 = 0, sigma of a1 is
/// the largest a1 within one sigma of a1', sigma of b1 is infinite, and the result is "not
/// resolved" (false).
/// @param solution  theta' = {b0', b1', a1', ..}: further entries (offset) are not touched
/// @param variance  of one row, to scale solution.inverse
struct SiaExactMap {
  double period_s = 0.01;
  double delta_s = 0.0;

  template <int P>
  bool operator()(const LeastSquaresSolution<P>& solution,
                  double variance,
                  Estimate<P>& estimate) const {
    static_assert(P >= 3);
    ReportAsSolved<P>()(solution, variance, estimate);
    const double* inverse = solution.inverse.data();
    return Apply(inverse, variance, estimate.theta.data(), estimate.sigma.data());
  }

  /// The same on plain arrays: theta and sigma are those of theta' on entry and those of theta on
  /// return.
  bool Apply(const double* inverse, double variance, double* theta, double* sigma) const;
};

/// Paper or exact, chosen at run time.
template <int P>
struct SiaReport {
  SiaMode mode = SiaMode::kPaper;
  SiaExactMap exact;

  bool operator()(const LeastSquaresSolution<P>& solution,
                  double variance,
                  Estimate<P>& estimate) const {
    if constexpr (P == 3 || P == 4) {
      if (mode == SiaMode::kExact) {
        return exact(solution, variance, estimate);
      }
    }
    return ReportAsSolved<P>()(solution, variance, estimate);
  }
};

}  // namespace faultlab::core
