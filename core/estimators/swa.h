#pragma once

#include <array>
#include <cstddef>

#include "core/estimators/row_history.h"
#include "core/estimators/window_estimator.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {

/// Whether a row ends in a column of ones, which absorbs a constant such as Coulomb friction while
/// the motor turns one way.
enum class RowForm { kPlain, kAffine };

/// SWA's parameters: b0d .. bvd, a1d .. avd, then the constant (volt) of the affine form.
template <int Order, RowForm Form = RowForm::kPlain>
inline constexpr int kSwaParameters = 2 * Order + 1 + (Form == RowForm::kAffine ? 1 : 0);

/// The tolerances of excitation_gate.h for SWA.
template <int Order, RowForm Form = RowForm::kPlain>
constexpr ExcitationGate<kSwaParameters<Order, Form>> SwaGate() {
  ExcitationGate<kSwaParameters<Order, Form>> gate;
  gate.absolute.fill(kDiscreteTolerance);
  if (Form == RowForm::kAffine) {
    gate.absolute.back() = kOffsetTolerance_v;
  }
  gate.relative = kRelativeTolerance;
  return gate;
}

template <int Order, RowForm Form = RowForm::kPlain>
struct SwaOptions {
  int window_samples = 100;  ///< K, more than the parameters
  ExcitationGate<kSwaParameters<Order, Form>> gate = SwaGate<Order, Form>();
  double noise_sigma_v = 0.0;  ///< > 0: white noise of y, subtracted from the normal equations
};

/// Rows of SWA: [u(k) .. u(k-v)  -y(k-1) .. -y(k-v)  (1)], y(k). A row exists after v + 1
/// consecutive good samples.
template <int Order, RowForm Form = RowForm::kPlain>
class SwaRows {
 public:
  static_assert(Order >= 1);
  static constexpr int kParameters = kSwaParameters<Order, Form>;
  using Row = std::array<double, kParameters + 1>;

  RowKind Push(double u_v, double y_v, Row& row) {
    if (!IsPlausible(u_v) || !IsPlausible(y_v)) {
      Remember(0.0, 0.0);
      return history_.PushInvalid();
    }
    row[0] = u_v;
    for (std::size_t j = 0; j < Order; ++j) {
      row[1 + j] = past_u_[j];
      row[1 + Order + j] = -past_y_[j];
    }
    if (Form == RowForm::kAffine) {
      row[kParameters - 1] = 1.0;
    }
    row[kParameters] = y_v;
    Remember(u_v, y_v);
    return history_.PushGood();
  }

  RowKind PushUnusable() {
    Remember(0.0, 0.0);
    return history_.PushUnusable();
  }

  void Break() { history_.Break(); }

 private:
  void Remember(double u_v, double y_v) {
    for (std::size_t j = Order - 1; j > 0; --j) {
      past_u_[j] = past_u_[j - 1];
      past_y_[j] = past_y_[j - 1];
    }
    past_u_[0] = u_v;
    past_y_[0] = y_v;
  }

  std::array<double, Order> past_u_{};
  std::array<double, Order> past_y_{};
  RowHistory history_{Order};
};

/// Sliding Window Algorithm: least squares of the discrete model over the newest K rows,
///   y(k) = [u(k) .. u(k-v)  -y(k-1) .. -y(k-v)  (1)] [b0d .. bvd  a1d .. avd  (offset)]'
/// v = Order >= 1, u = uc (V), y = um (V); theta in V/V, offset in V.
/// Noise of y biases a1d and b1d toward zero by about 2.5 % at 1.4 % noise, for every K; a known
/// noise_sigma_v removes it to first order.
/// For statuses and gaps see SlidingLeastSquares. Source: paper Eq. (10)-(16).
template <int Order, RowForm Form = RowForm::kPlain>
class Swa : public WindowEstimator<SwaRows<Order, Form>> {
 public:
  using Base = WindowEstimator<SwaRows<Order, Form>>;
  using Options = SwaOptions<Order, Form>;

  explicit Swa(const Options& options) : Base({}, options.window_samples, options.gate) {
    if (options.noise_sigma_v > 0.0) {
      const double variance = options.noise_sigma_v * options.noise_sigma_v;
      typename Base::Kernel::Moments::Packed per_row{};
      for (int j = 0; j < Order; ++j) {
        per_row[PackedIndex(1 + Order + j, 1 + Order + j)] = variance;
      }
      per_row[PackedIndex(Base::kParameters, Base::kParameters)] = variance;
      Base::CompensateNoise(per_row);
    }
  }
};

}  // namespace faultlab::core
