#pragma once

#include <array>

#include "core/estimators/row_history.h"
#include "core/estimators/sliding_moments.h"
#include "core/estimators/swa.h"
#include "core/types/estimate.h"

namespace faultlab::core {

/// SWA of order 1 with a constant, solved with instruments instead of least squares:
///   Z' Phi theta = Z' Y,  phi = [u(k) u(k-1) -y(k-1) 1],  z = [u(k) u(k-1) -x(k-1) 1],
/// where x is the output simulated with the estimator's own last usable theta. x follows y but not
/// its noise, so b1d and a1d have no noise bias (see Swa), although the noise level is unknown.
/// theta = {b0d, b1d, a1d, offset}; covariance s^2 (Z'Phi)^-1 Z'Z (Phi'Z)^-1, sse of the rows'
/// errors, condition of Z'Phi scaled to unit columns and rows. Statuses, gaps, holding and cost as
/// in SlidingLeastSquares. Not thread-safe.
/// Source: Soderstrom and Stoica, System Identification (1989), chapter 8.
class InstrumentalSwa {
 public:
  static constexpr int kParameters = 4;
  using Options = SwaOptions<1, RowForm::kAffine>;

  /// Throws ContractError unless options.window_samples > 4.
  explicit InstrumentalSwa(const Options& options);

  const Estimate<kParameters>& Push(double u_v, double y_v);
  const Estimate<kParameters>& PushUnusable();
  void Skip(int samples);

  const Estimate<kParameters>& estimate() const { return estimate_; }

 private:
  /// u(k), u(k-1), -y(k-1), 1, -x(k-1), y(k).
  using Moments = SlidingMoments<6>;

  const Estimate<kParameters>& Update();
  const Estimate<kParameters>& Hold(EstimateStatus status);
  void Simulate(double u_v);
  void Remember(double u_v, double y_v);

  Options options_;
  RowHistory history_;
  Moments moments_;
  Estimate<kParameters> estimate_;
  std::array<double, kParameters> model_{};  ///< theta that drives x
  bool has_model_ = false;
  double past_u_v_ = 0.0;
  double past_y_v_ = 0.0;
  double simulated_v_ = 0.0;
};

}  // namespace faultlab::core
