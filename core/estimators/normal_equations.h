#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "core/estimators/excitation_gate.h"
#include "core/estimators/sliding_moments.h"

namespace faultlab::core {

/// theta [P], the inverse of the normal matrix [P x P, packed], the sum of squared residuals and
/// the condition number. `regular` is false when a pivot vanished: then condition is infinite and
/// the rest is not set.
template <int P>
struct LeastSquaresSolution {
  std::array<double, P> theta;
  std::array<double, PackedSize(P)> inverse;
  double sse;
  double condition;
  bool regular;
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
  out.regular = regular;
  if (!regular) {
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

/// The same for the three parameters of a first-order model, the work of every sample: L D L' with
/// its rows scaled by the pivots before them (n_ij = a_00 d_1-row, o_ij = n_11 d_2-row), so that
/// the divisions wait for nothing but their pivots instead of for each other.
template <>
inline void SolveNormalEquations<3>(const std::array<double, PackedSize(4)>& sums,
                                    LeastSquaresSolution<3>& out) {
  const auto [a00, a10, a11, a20, a21, a22, r0, r1, r2, yy] = sums;
  const double n11 = a00 * a11 - a10 * a10;
  const double n21 = a00 * a21 - a10 * a20;
  const double n22 = a00 * a22 - a20 * a20;
  const double n31 = a00 * r1 - a10 * r0;
  const double n32 = a00 * r2 - a20 * r0;
  const double n33 = a00 * yy - r0 * r0;
  const double o22 = n11 * n22 - n21 * n21;
  const double o32 = n11 * n32 - n21 * n31;
  const double o33 = n11 * n33 - n31 * n31;
  const double a00_a11 = a00 * a11;
  out.regular = a00 > 0.0 && n11 > kPivotFloor * a00_a11 && o22 > kPivotFloor * (a00 * a22) * n11;
  if (!out.regular) {
    out.condition = std::numeric_limits<double>::infinity();
    return;
  }
  const double w0 = 1.0 / a00;  // w_j: reciprocals of the pivots d_j
  const double i1 = 1.0 / n11;
  const double i2 = 1.0 / o22;
  const double w1 = a00 * i1;
  const double w2 = a00 * n11 * i2;
  const double theta2 = o32 * i2;
  const double theta1 = (n31 - n21 * theta2) * i1;
  out.theta = {(r0 - a10 * theta1 - a20 * theta2) * w0, theta1, theta2};
  const double sse = (o33 - o32 * theta2) * (w0 * i1);
  out.sse = sse > 0.0 ? sse : 0.0;
  const double l10 = a10 * w0;
  const double l21 = n21 * i1;
  const double m20 = l10 * l21 - a20 * w0;
  const double v22 = w2;
  const double v21 = -l21 * w2;
  const double v20 = m20 * w2;
  const double v11 = w1 + l21 * l21 * w2;
  const double v10 = -l10 * w1 + m20 * v21;
  const double v00 = w0 + l10 * l10 * w1 + m20 * v20;
  out.inverse = {v00, v10, v11, v20, v21, v22};
  const double norm =
      3.0 + 2.0 * (a10 * a10 * a22 + a20 * a20 * a11 + a21 * a21 * a00) / (a00_a11 * a22);
  const double inverse_norm =
      v00 * v00 * (a00 * a00) + v11 * v11 * (a11 * a11) + v22 * v22 * (a22 * a22) +
      2.0 * (v10 * v10 * a00_a11 + v20 * v20 * (a00 * a22) + v21 * v21 * (a11 * a22));
  out.condition = std::sqrt(norm * inverse_norm);
}

}  // namespace faultlab::core
