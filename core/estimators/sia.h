#pragma once

#include <array>
#include <cstddef>

#include "core/estimators/row_history.h"
#include "core/estimators/sia_mode.h"
#include "core/estimators/sia_report.h"
#include "core/estimators/sliding_integral.h"
#include "core/estimators/swa.h"
#include "core/estimators/window_estimator.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {

/// SIA's parameters: b0 .. bn, a1 .. an, then the constant of the affine form.
template <int Order, RowForm Form = RowForm::kPlain>
inline constexpr int kSiaParameters = 2 * Order + 1 + (Form == RowForm::kAffine ? 1 : 0);

/// The tolerances of excitation_gate.h for SIA.
template <int Order, RowForm Form = RowForm::kPlain>
constexpr ExcitationGate<kSiaParameters<Order, Form>> SiaGate() {
  ExcitationGate<kSiaParameters<Order, Form>> gate;
  gate.absolute.fill(kTimeConstantTolerance_s);
  gate.absolute.front() = kGainTolerance;
  if (Form == RowForm::kAffine) {
    gate.absolute.back() = kOffsetTolerance_v;
  }
  gate.relative = kRelativeTolerance;
  return gate;
}

template <int Order, RowForm Form = RowForm::kPlain>
struct SiaOptions {
  int window_samples = 100;   ///< K, more than the parameters
  int integral_samples = 20;  ///< m, 1 .. K - 1
  double period_s = 0.01;
  SiaMode mode = SiaMode::kPaper;  ///< kExact needs Order == 1
  double delta_s = 0.0;            ///< DAC edge to ADC sample; used by kExact
  ExcitationGate<kSiaParameters<Order, Form>> gate = SiaGate<Order, Form>();
  double noise_sigma_v = 0.0;  ///< > 0: white noise of y, subtracted from the normal equations
};

/// Rows of SIA: [rho0 u .. rhon u  -rho1 y .. -rhon y  ((T m)^n)], rho0 y. A row exists after n m +
/// 1 consecutive good samples.
template <int Order, RowForm Form = RowForm::kPlain>
class SiaRows {
 public:
  static_assert(Order >= 1);
  static constexpr int kParameters = kSiaParameters<Order, Form>;
  using Row = std::array<double, kParameters + 1>;

  SiaRows(int integral_samples, double period_s)
      : u_(integral_samples, period_s),
        y_(integral_samples, period_s),
        one_(IntegralOfOne(integral_samples, period_s)),
        history_(Order * integral_samples) {}

  RowKind Push(double u_v, double y_v, Row& row) {
    if (!IsPlausible(u_v) || !IsPlausible(y_v)) {
      u_.Push(0.0);
      y_.Push(0.0);
      return history_.PushInvalid();
    }
    const std::array<double, Order + 1> u = u_.Push(u_v);
    const std::array<double, Order + 1> y = y_.Push(y_v);
    for (std::size_t j = 0; j <= Order; ++j) {
      row[j] = u[j];
    }
    for (std::size_t j = 1; j <= Order; ++j) {
      row[Order + j] = -y[j];
    }
    if (Form == RowForm::kAffine) {
      row[kParameters - 1] = one_;
    }
    row[kParameters] = y[0];
    return history_.PushGood();
  }

  RowKind PushUnusable() {
    u_.Push(0.0);
    y_.Push(0.0);
    return history_.PushUnusable();
  }

  void Break() { history_.Break(); }

 private:
  static double IntegralOfOne(int integral_samples, double period_s) {
    double value = 1.0;
    for (int j = 0; j < Order; ++j) {
      value *= period_s * integral_samples;
    }
    return value;
  }

  NestedIntegrals<Order> u_;
  NestedIntegrals<Order> y_;
  double one_;
  RowHistory history_;
};

/// Sliding Integral Algorithm: n nested sliding integrals of length m turn the differential
/// equation
///   y + a1 y' + .. + an y(n) = b0 u + b1 u' + .. + bn u(n)  (+ offset)
/// into rows free of derivatives and initial states, solved by least squares over K rows:
///   rho0 y(k) = [rho0 u .. rhon u  -rho1 y .. -rhon y  ((T m)^n)] [b0 .. bn  a1 .. an  (offset)]'
///   rhoj = T^(n-j) Q^(n-j) (1 - z^-m)^j,   Q = z^-1 + .. + z^-m
/// theta: b_i, a_i in s^i, offset in V. Standard errors assume white errors of the rows, as the
/// paper's least squares does; integrals overlap, so they are only approximate (see README).
/// Source: paper Eq. (17)-(31); the limited data window K is the paper's modification.
template <int Order, RowForm Form = RowForm::kPlain>
class Sia : public WindowEstimator<SiaRows<Order, Form>, SiaReport<kSiaParameters<Order, Form>>> {
 public:
  using Base = WindowEstimator<SiaRows<Order, Form>, SiaReport<kSiaParameters<Order, Form>>>;
  using Options = SiaOptions<Order, Form>;

  explicit Sia(const Options& options)
      : Base({options.integral_samples, options.period_s},
             options.window_samples,
             options.gate,
             {options.mode, {options.period_s, options.delta_s}}) {
    LAB_CHECK(options.integral_samples < options.window_samples,
              options.integral_samples,
              options.window_samples);
    LAB_CHECK(Order == 1 || options.mode == SiaMode::kPaper);
    if (options.noise_sigma_v > 0.0) {
      CompensateNoise(options);
    }
  }

 private:
  /// White noise of y enters -rho1 y .. -rhon y and rho0 y together. The covariances of these
  /// sequences per row follow from the coefficients of rhoj, which are its response to a unit
  /// impulse.
  void CompensateNoise(const Options& options) {
    constexpr int kY = Base::kParameters;
    NestedIntegrals<Order> impulse(options.integral_samples, options.period_s);
    typename Base::Kernel::Moments::Packed per_row{};
    for (int k = 0; k <= impulse.reach_samples(); ++k) {
      const std::array<double, Order + 1> rho = impulse.Push(k == 0 ? options.noise_sigma_v : 0.0);
      for (int i = 1; i <= Order; ++i) {
        const double entry_i = -rho[static_cast<std::size_t>(i)];
        for (int j = 1; j <= i; ++j) {
          per_row[PackedIndex(Order + i, Order + j)] -= entry_i * rho[static_cast<std::size_t>(j)];
        }
        per_row[PackedIndex(kY, Order + i)] += entry_i * rho[0];
      }
      per_row[PackedIndex(kY, kY)] += rho[0] * rho[0];
    }
    Base::CompensateNoise(per_row);
  }
};

}  // namespace faultlab::core
