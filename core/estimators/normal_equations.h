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
  std::array<double, P> theta{};
  std::array<double, PackedSize(P)> inverse{};
  double sse = 0.0;
  double condition = std::numeric_limits<double>::infinity();
  bool regular = false;
};

/// Least squares from the packed sums of rows z = [phi_1 .. phi_P, y]:
///   N theta = r,  N = sum phi phi',  r = sum phi y,  sse = sum y^2 - r' theta
/// by L D L' of the whole (P+1) x (P+1) matrix, whose last pivot is sse. The condition number is
/// |S|_F |S^-1|_F of the unit-diagonal S = diag(N)^-1/2 N diag(N)^-1/2: free of units, at least
/// the 2-norm condition number of S and at most P times it.
/// Straight-line code for a fixed P; no allocation.
template <int P>
inline LeastSquaresSolution<P> SolveNormalEquations(
    const std::array<double, PackedSize(P + 1)>& sums) {
  LeastSquaresSolution<P> out;
  std::array<double, PackedSize(P + 1)> l;       // unit lower triangle, diagonal unused
  std::array<double, P> reciprocal;              // 1 / d_j
  std::array<double, PackedSize(P + 1)> scaled;  // l_ij d_j
  bool regular = true;
  for (int j = 0; j < P; ++j) {
    double pivot = sums[PackedIndex(j, j)];
    const double floor = kPivotFloor * pivot;
    for (int k = 0; k < j; ++k) {
      pivot -= scaled[PackedIndex(j, k)] * l[PackedIndex(j, k)];
    }
    regular &= pivot > floor;  // false for NaN too
    reciprocal[static_cast<std::size_t>(j)] = 1.0 / pivot;
    for (int i = j + 1; i <= P; ++i) {
      double entry = sums[PackedIndex(i, j)];
      for (int k = 0; k < j; ++k) {
        entry -= scaled[PackedIndex(i, k)] * l[PackedIndex(j, k)];
      }
      scaled[PackedIndex(i, j)] = entry;
      l[PackedIndex(i, j)] = entry * reciprocal[static_cast<std::size_t>(j)];
    }
  }
  if (!regular) {
    return out;
  }
  double sse = sums[PackedIndex(P, P)];
  for (int k = 0; k < P; ++k) {
    sse -= scaled[PackedIndex(P, k)] * l[PackedIndex(P, k)];
  }
  out.sse = sse > 0.0 ? sse : 0.0;
  // Row P of L holds L' theta; rows of the inverse of L follow by forward substitution.
  std::array<double, PackedSize(P)> m;
  for (int i = P - 1; i >= 0; --i) {
    double value = l[PackedIndex(P, i)];
    for (int k = i + 1; k < P; ++k) {
      value -= l[PackedIndex(k, i)] * out.theta[static_cast<std::size_t>(k)];
    }
    out.theta[static_cast<std::size_t>(i)] = value;
  }
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
  std::array<double, P> unit;
  for (int i = 0; i < P; ++i) {
    unit[static_cast<std::size_t>(i)] = 1.0 / sums[PackedIndex(i, i)];
  }
  for (int i = 0; i < P; ++i) {
    for (int j = 0; j <= i; ++j) {
      double value = 0.0;
      for (int k = i; k < P; ++k) {
        value +=
            m[PackedIndex(k, i)] * m[PackedIndex(k, j)] * reciprocal[static_cast<std::size_t>(k)];
      }
      out.inverse[PackedIndex(i, j)] = value;
      const double weight = i == j ? 1.0 : 2.0;
      inverse_norm += weight * value * value * sums[PackedIndex(i, i)] * sums[PackedIndex(j, j)];
      if (i != j) {
        const double entry = sums[PackedIndex(i, j)];
        norm += 2.0 * entry * entry * unit[static_cast<std::size_t>(i)] *
                unit[static_cast<std::size_t>(j)];
      }
    }
  }
  out.condition = std::sqrt(norm * inverse_norm);
  out.regular = true;
  return out;
}

}  // namespace faultlab::core
