#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "core/estimators/estimator_variant.h"
#include "core/methods/method.h"
#include "core/plant/coefficients.h"
#include "core/types/check.h"

namespace faultlab::core {

/// SWA (m = 0), or SIA with the rule of its integrals inverted, of first order, with the calibrated
/// noise of the output subtracted.
inline VariantSpec FirstOrderSpec(const MethodTask& task,
                                  double window,
                                  int integral,
                                  bool affine) {
  VariantSpec spec;
  spec.method = integral > 0 ? EstimatorMethod::kSia : EstimatorMethod::kSwa;
  spec.window_samples = static_cast<int>(std::lround(window));
  spec.integral_samples = integral;
  spec.affine = affine;
  spec.noise_sigma_v = task.noise() * ReadingPerOutput(task.bench->nominal);
  spec.period_s = task.period_s;
  spec.channel = task.bench->structure->estimated;
  if (integral > 0) {
    spec.sia_mode = SiaMode::kExact;
    spec.delta_s = task.calibration.delta_s;
  }
  return spec;
}
/// The paper's length of the integrals for a data length K.
inline int PaperIntegral(double window) {
  return window < 50.0 ? 5 : 20;
}

/// An estimator of first order, and its mean and spread over the healthy stretch.
class EstimateBands {
 public:
  EstimateBands(const MethodTask& task, const VariantSpec& spec) : estimator_(Made(spec)) {
    // The estimator takes samples; of the healthy stretch only observations were kept.
    Sample sample;
    const double unit = ReadingPerOutput(task.bench->nominal);
    double count = 0.0;
    Values squares{};
    for (const Observation& o : task.healthy) {
      sample.t_s = static_cast<double>(sample.index) * task.period_s;
      sample.uc_v = o.u;
      ReadingOf(sample, spec.channel) = task.Has(o) ? unit * task.Reading(o) : kAbsent;
      Push(sample);
      ++sample.index;
      if (!usable()) continue;
      count += 1.0;
      for (std::size_t i = 0; i < mean_.size(); ++i) {
        const double off = estimate_.theta[i] - mean_[i];
        mean_[i] += off / count;
        squares[i] += off * (estimate_.theta[i] - mean_[i]);
        if (std::isfinite(estimate_.sigma[i])) sd_[i] = estimate_.sigma[i];
      }
    }
    if (count == 0.0) mean_ = Calibrated(task, spec);  // the window is longer than the stretch
    // A stretch holds few independent windows: never below the estimate's own standard error.
    for (std::size_t i = 0; i < sd_.size(); ++i) {
      constexpr std::array kUnmeasured = {0.005, 0.04, 0.04};  // of b0, b1, a1
      const double spread =
          count > 0.0 ? std::sqrt(squares[i] / count) : kUnmeasured[i] * std::abs(mean_[i]);
      sd_[i] = std::max({sd_[i], spread, 1e-9});
    }
    estimator_ = Made(spec);
    estimate_ = {};
  }

  using Values = std::array<double, 3>;

  void Push(const Sample& sample) { estimate_ = estimator_->Push(sample); }
  bool usable() const {
    return estimate_.status == EstimateStatus::kExcited ||
           estimate_.status == EstimateStatus::kWeak;
  }
  Values theta() const { return {estimate_.theta[0], estimate_.theta[1], estimate_.theta[2]}; }
  const Values& mean() const { return mean_; }
  const Values& sd() const { return sd_; }
  /// The largest distance of a coefficient from its healthy mean, in standard deviations.
  double Distance() const {
    double most = 0.0;
    if (!usable()) return most;
    for (std::size_t i = 0; i < mean_.size(); ++i) {
      most = std::max(most, std::abs(theta()[i] - mean_[i]) / sd_[i]);
    }
    return most;
  }

 private:
  static Values Calibrated(const MethodTask& task, const VariantSpec& spec) {
    const Calibration& known = task.calibration;
    ContinuousCoefficients c = MakeContinuous(known.nominal);
    c.b0 *= known.gain_factor;
    c.b1 *= known.gain_factor;
    if (spec.method == EstimatorMethod::kSia) return {c.b0, c.b1, c.a1};
    const DiscreteCoefficients d = Discretise(c, task.period_s, known.delta_s);
    return {d.b0d, d.b1d, d.a1d};
  }
  static std::unique_ptr<VariantEstimator> Made(const VariantSpec& spec) {
    Result<std::unique_ptr<VariantEstimator>> made = MakeVariant(spec);
    LAB_CHECK(made.ok(), spec.window_samples, spec.integral_samples);
    return std::move(made).value();
  }

  std::unique_ptr<VariantEstimator> estimator_;
  VariantEstimate estimate_{};
  Values mean_{};
  Values sd_{};
};

}  // namespace faultlab::core
