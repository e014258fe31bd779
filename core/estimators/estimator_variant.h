#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/estimators/sia_mode.h"
#include "core/types/estimate.h"
#include "core/types/plant_parameters.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::core {

enum class EstimatorMethod { kSwa, kSia };

/// One estimator of a window or data-length study (paper Figures 17-20), described at run time.
struct VariantSpec {
  EstimatorMethod method = EstimatorMethod::kSwa;
  int order = 1;               ///< 1 .. kOrderMax
  int window_samples = 100;    ///< K, 2 * parameters .. kWindowMax
  int integral_samples = 0;    ///< m, SIA only, 1 .. K - 1
  bool affine = false;         ///< an added column of ones absorbs Coulomb friction
  bool instrumental = false;   ///< SWA order 1: u(k), u(k-1), ysim(k-1), 1; removes noise bias
  double noise_sigma_v = 0.0;  ///< > 0: subtract this output noise from the normal equations
  SiaMode sia_mode = SiaMode::kPaper;
  double delta_s = 0.0;  ///< SIA exact mode
  double period_s = 0.01;
  EstimatedChannel channel = EstimatedChannel::kUm;  ///< what is fitted
};

inline constexpr int kWindowMax = 100'000;
inline constexpr int kOrderMax = 4;
inline constexpr int kVariantParametersMax = 2 * kOrderMax + 2;

/// An estimate of any variant: the first `parameters` entries of theta and sigma are used.
/// SWA {b0d..bvd, a1d..avd, offset?}, SIA {b0..bn, a1..an, offset?}.
using VariantEstimate = Estimate<kVariantParametersMax>;

/// One estimator with the shape chosen at run time. It follows the rules of EstimatorBank for gaps,
/// repeated and non-finite samples. Built by MakeVariant.
class VariantEstimator {
 public:
  virtual ~VariantEstimator() = default;
  virtual const VariantEstimate& Push(const Sample& sample) = 0;

  const VariantSpec& spec() const { return spec_; }
  int parameters() const { return parameters_; }

 protected:
  VariantEstimator(const VariantSpec& spec, int parameters)
      : spec_(spec), parameters_(parameters) {}

 private:
  VariantSpec spec_;
  int parameters_;
};

/// Refuses what the table above excludes, and names the field.
Result<std::unique_ptr<VariantEstimator>> MakeVariant(const VariantSpec& spec);

/// "swa_100", "sia_500_20", with suffixes "_o2", "_affine", "_iv", "_exact", "_nc".
std::string Name(const VariantSpec& spec);
/// "b0d", "b1d", "a1d", "offset" or "b0", "b1", "a1", ..
std::vector<std::string> ParameterNames(const VariantSpec& spec);

/// Runs every variant over one record; row r of the result belongs to specs[r], entry k to
/// samples[k].
Result<std::vector<std::vector<VariantEstimate>>> RunStudy(std::span<const VariantSpec> specs,
                                                           std::span<const Sample> samples);

}  // namespace faultlab::core
