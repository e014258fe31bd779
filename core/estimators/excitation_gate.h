#pragma once

#include <array>
#include <cmath>

namespace faultlab::core {

/// Above this condition number of the unit-diagonal normal matrix the rounding error of the sums
/// (1e-15 relative, a few hundred rows) reaches the seventh digit of theta. On records of the bench
/// every such window contained fewer than two input switches: the result would come from rounding,
/// not from measurement.
inline constexpr double kConditionMax = 1e8;

/// A pivot of the factorisation below this share of its diagonal entry is a rounding error, not
/// information (it implies a condition number of at least 1e12).
inline constexpr double kPivotFloor = 1e-12;

/// When an estimate may be called `excited`: every reported parameter has
///   sigma_i <= absolute_i + relative * |theta_i|   and   condition < condition_max.
/// sigma above tolerance makes it `weak`; condition beyond the bound makes it `not_excited`.
template <int P>
struct ExcitationGate {
  std::array<double, P> absolute{};
  double relative = 0.0;
  double condition_max = kConditionMax;

  bool Accepts(const std::array<double, P>& theta, const std::array<double, P>& sigma) const {
    bool accepted = true;
    for (int i = 0; i < P; ++i) {
      const auto at = static_cast<std::size_t>(i);
      accepted &= sigma[at] <= absolute[at] + relative * std::abs(theta[at]);
    }
    return accepted;
  }
};

/// A quarter of the value: with a larger standard error an estimate cannot show a 50 % fault at two
/// sigma, which a student should be able to read from the chart.
inline constexpr double kRelativeTolerance = 0.25;
/// SWA, volt/volt: 4 % of the nominal gain 2.4; keeps parameters that pass through zero readable.
inline constexpr double kDiscreteTolerance = 0.1;
/// SIA b0, volt/volt, the same 4 %.
inline constexpr double kGainTolerance = 0.1;
/// SIA b_i and a_i, second^i: half a sample period; sampled data hardly show smaller changes.
inline constexpr double kTimeConstantTolerance_s = 5e-3;
/// Constant of the affine column, volt: the Coulomb offset R1 Ke Mc / D reaches 1 V at R1 = 100
/// ohm.
inline constexpr double kOffsetTolerance_v = 0.5;

}  // namespace faultlab::core
