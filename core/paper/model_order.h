#pragma once

#include <span>
#include <vector>

#include "core/estimators/estimator_variant.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// y(k) = sum over i = 0 .. n of b[i] u(k-i)  -  sum over i = 1 .. n of a[i-1] y(k-i)  +  offset
struct DifferenceEquation {
  std::vector<double> b;  ///< n + 1
  std::vector<double> a;  ///< n
  double offset = 0.0;
};

/// What an estimate says of the next reading, whatever its method: SWA's own equation; of SIA its
/// transfer function by the rule of its integrals, s = (z - 1) / T, or as its exact mode samples
/// it. Values are not finite where theta says nothing of the next reading (a_n = 0).
DifferenceEquation DifferenceOf(const VariantSpec& spec, std::span<const double> theta);

/// What a model leaves of the readings, each predicted from those before it. White residuals: a
/// higher order has nothing more to explain (noise of the sensor alone wants orders, too). An order
/// that is too high gains less than its parameters cost.
struct OrderEvidence {
  int count = 0;             ///< residuals
  double rms = 0.0;          ///< of them, in the unit of y
  double ljung_box = 0.0;    ///< of their first kLags autocorrelations
  double white_below = 0.0;  ///< chi-square, 95 %; means of windows fit a little worse
  double bic = 0.0;          ///< count ln(mean square) + parameters ln(count)

  static constexpr int kLags = 20;
  bool white() const { return ljung_box < white_below; }
};

/// No answer: fewer than 2 kLags residuals, or none that differs from 0; then its numbers are NaN.
/// The first kOrderMax rows, those behind a gap, and with a reading that is none, have no residual,
/// so that models of each order have the same.
/// Source: G. M. Ljung, G. E. P. Box, Biometrika 65 (1978); G. Schwarz, Ann. Statist. 6 (1978).
OrderEvidence JudgeOrder(const VariantSpec& spec,
                         std::span<const double> theta,
                         std::span<const Sample> stretch);

}  // namespace faultlab::core
