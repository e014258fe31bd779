#pragma once

#include <limits>

#include "core/estimators/excitation_gate.h"
#include "core/numerics/lanes.h"

namespace faultlab::core {

/// theta [3], the packed inverse of the normal matrix [6], the sum of squared residuals and the
/// condition number of SolveFirstOrder; Value is double, or two of them side by side (lanes.h).
template <typename Value>
struct FirstOrderSolution {
  Value theta[3];
  Value inverse[6];
  Value sse;
  Value condition;  ///< infinite when a pivot vanished; then sse is NaN and the rest is not valid
};

/// The least squares of SolveNormalEquations for three parameters, computed at every sample: L D L'
/// with each row scaled by the pivots before it (n = a00 d1-row, o = n11 d2-row), so that all four
/// reciprocals come from one division. One problem and two side by side use the same operations in
/// the same order, so they give the same bits.
/// @param sums  packed lower triangle of sum z z', z = [phi1 phi2 phi3 y]
template <typename Value>
[[gnu::always_inline]] inline void SolveFirstOrder(const Value* sums,
                                                   FirstOrderSolution<Value>& out) {
  const Value a00 = sums[0], a10 = sums[1], a11 = sums[2], a20 = sums[3], a21 = sums[4],
              a22 = sums[5], r0 = sums[6], r1 = sums[7], r2 = sums[8], yy = sums[9];
  const Value a00_a11 = a00 * a11;
  const Value a00_a22 = a00 * a22;
  const Value a11_a22 = a11 * a22;
  const Value a10_a10 = a10 * a10;
  const Value a20_a20 = a20 * a20;
  const Value n11 = a00_a11 - a10_a10;
  const Value n21 = a00 * a21 - a10 * a20;
  const Value n22 = a00_a22 - a20_a20;
  const Value n31 = a00 * r1 - a10 * r0;
  const Value n32 = a00 * r2 - a20 * r0;
  const Value n33 = a00 * yy - r0 * r0;
  const Value o22 = n11 * n22 - n21 * n21;
  const Value o32 = n11 * n32 - n21 * n31;
  const Value o33 = n11 * n33 - n31 * n31;
  const auto regular =
      (a00 > 0.0) & (n11 > kPivotFloor * a00_a11) & (o22 > kPivotFloor * (a00_a22 * n11));
  // a00 a11 a22 n11 o22 is of the ninth degree in the sums: it neither underflows nor overflows for
  // sums from 1e-30 to 1e30.
  const Value diagonal = a00 * a11_a22;
  const Value pivots = n11 * o22;
  const Value reciprocal = 1.0 / (diagonal * pivots);
  const Value per_diagonal = reciprocal * pivots;
  const Value per_pivots = reciprocal * diagonal;
  const Value w0 = per_diagonal * a11_a22;  // w_j: reciprocals of the pivots d_j
  const Value i1 = per_pivots * o22;        // 1 / n11
  const Value i2 = per_pivots * n11;        // 1 / o22
  const Value w1 = a00 * i1;
  const Value w2 = (a00 * n11) * i2;
  const Value theta2 = o32 * i2;
  const Value theta1 = (n31 - n21 * theta2) * i1;
  out.theta[2] = theta2;
  out.theta[1] = theta1;
  out.theta[0] = (r0 - a10 * theta1 - a20 * theta2) * w0;
  const Value sse = (o33 - o32 * theta2) * (w0 * i1);
  const Value none{};
  const Value not_a_number = none + std::numeric_limits<double>::quiet_NaN();
  out.sse = regular ? (sse > 0.0 ? sse : none) : not_a_number;
  const Value l10 = a10 * w0;
  const Value l21 = n21 * i1;
  const Value m20 = l10 * l21 - a20 * w0;
  const Value v21 = -l21 * w2;
  const Value v20 = m20 * w2;
  const Value v11 = w1 - l21 * v21;
  const Value l10_w1 = l10 * w1;
  const Value v10 = m20 * v21 - l10_w1;
  const Value v00 = w0 + l10 * l10_w1 + m20 * v20;
  out.inverse[0] = v00;
  out.inverse[1] = v10;
  out.inverse[2] = v11;
  out.inverse[3] = v20;
  out.inverse[4] = v21;
  out.inverse[5] = w2;
  const Value norm = 3.0 + 2.0 * (a10_a10 * a22 + a20_a20 * a11 + (a21 * a21) * a00) * per_diagonal;
  const Value s0 = v00 * a00;
  const Value s1 = v11 * a11;
  const Value s2 = w2 * a22;
  const Value inverse_norm =
      s0 * s0 + s1 * s1 + s2 * s2 +
      2.0 * ((v10 * v10) * a00_a11 + (v20 * v20) * a00_a22 + (v21 * v21) * a11_a22);
  const Value condition = SquareRoot(norm * inverse_norm);
  out.condition = regular ? condition : none + std::numeric_limits<double>::infinity();
}

}  // namespace faultlab::core
