#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/estimators/excitation_gate.h"
#include "core/estimators/first_order_solve.h"
#include "core/estimators/sliding_moments.h"

namespace faultlab::core {

/// theta [P], the inverse of the normal matrix [P x P, packed], the sum of squared residuals and
/// the condition number. If a pivot vanished, condition is infinite, sse is NaN and the rest is not
/// set.
template <int P>
struct LeastSquaresSolution {
  std::array<double, P> theta;
  std::array<double, PackedSize(P)> inverse;
  double sse;
  double condition;
};

/// Least squares from the packed sums of rows z = [phi_1 .. phi_P, y]:
///   N theta = r,  N = sum phi phi',  r = sum phi y,  sse = sum y^2 - r' theta
/// by L D L' of the whole (P+1) x (P+1) matrix, whose last pivot is sse. The condition number is
/// |S|_F |S^-1|_F of the unit-diagonal S = diag(N)^-1/2 N diag(N)^-1/2: free of units, at least
/// the 2-norm condition number of S and at most P times it.
/// Straight-line code for a fixed P; no allocation.
template <int P>
inline void SolveNormalEquations(const std::array<double, PackedSize(P + 1)>& sums,
                                 LeastSquaresSolution<P>& out) {
  std::array<double, PackedSize(P + 1)> l;       // unit lower triangle, diagonal unused
  std::array<double, PackedSize(P + 1)> scaled;  // l_ij d_j
  std::array<double, P> reciprocal;              // 1 / d_j
  bool regular = true;
  for (int j = 0; j < P; ++j) {
    const auto at = static_cast<std::size_t>(j);
    double pivot = sums[PackedIndex(j, j)];
    const double floor = kPivotFloor * pivot;
    for (int k = 0; k < j; ++k) {
      pivot -= scaled[PackedIndex(j, k)] * l[PackedIndex(j, k)];
    }
    regular &= pivot > floor;  // false for NaN too
    reciprocal[at] = 1.0 / pivot;
    for (int i = j + 1; i <= P; ++i) {
      double entry = sums[PackedIndex(i, j)];
      for (int k = 0; k < j; ++k) {
        entry -= scaled[PackedIndex(i, k)] * l[PackedIndex(j, k)];
      }
      scaled[PackedIndex(i, j)] = entry;
      l[PackedIndex(i, j)] = entry * reciprocal[at];
    }
  }
  if (!regular) {
    out.sse = std::numeric_limits<double>::quiet_NaN();
    out.condition = std::numeric_limits<double>::infinity();
    return;
  }
  double sse = sums[PackedIndex(P, P)];
  for (int k = 0; k < P; ++k) {
    sse -= scaled[PackedIndex(P, k)] * l[PackedIndex(P, k)];
  }
  out.sse = sse > 0.0 ? sse : 0.0;
  // Row P of L holds L' theta.
  for (int i = P - 1; i >= 0; --i) {
    double value = l[PackedIndex(P, i)];
    for (int k = i + 1; k < P; ++k) {
      value -= l[PackedIndex(k, i)] * out.theta[static_cast<std::size_t>(k)];
    }
    out.theta[static_cast<std::size_t>(i)] = value;
  }
  std::array<double, PackedSize(P)> m;  // the inverse of L, by forward substitution
  for (int j = 0; j < P; ++j) {
    m[PackedIndex(j, j)] = 1.0;
    for (int i = j + 1; i < P; ++i) {
      double value = -l[PackedIndex(i, j)];
      for (int k = j + 1; k < i; ++k) {
        value -= l[PackedIndex(i, k)] * m[PackedIndex(k, j)];
      }
      m[PackedIndex(i, j)] = value;
    }
  }
  double norm = P;
  double inverse_norm = 0.0;
  for (int i = 0; i < P; ++i) {
    const double diagonal_i = sums[PackedIndex(i, i)];
    for (int j = 0; j <= i; ++j) {
      double value = 0.0;
      for (int k = i; k < P; ++k) {
        value +=
            m[PackedIndex(k, i)] * m[PackedIndex(k, j)] * reciprocal[static_cast<std::size_t>(k)];
      }
      out.inverse[PackedIndex(i, j)] = value;
      const double product = diagonal_i * sums[PackedIndex(j, j)];
      inverse_norm += (i == j ? 1.0 : 2.0) * value * value * product;
      if (i != j) {
        const double entry = sums[PackedIndex(i, j)];
        norm += 2.0 * entry * entry / product;
      }
    }
  }
  out.condition = std::sqrt(norm * inverse_norm);
}

/// The three parameters of a first-order model, solved at every sample.
template <>
[[gnu::always_inline]] inline void SolveNormalEquations<3>(
    const std::array<double, PackedSize(4)>& sums, LeastSquaresSolution<3>& out) {
  FirstOrderSolution<double> solution;
  SolveFirstOrder(sums.data(), solution);
  std::copy_n(solution.theta, out.theta.size(), out.theta.begin());
  std::copy_n(solution.inverse, out.inverse.size(), out.inverse.begin());
  out.sse = solution.sse;
  out.condition = solution.condition;
}

}  // namespace faultlab::core
