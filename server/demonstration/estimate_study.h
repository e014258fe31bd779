#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/estimators/estimator_variant.h"
#include "core/types/fault.h"
#include "core/types/result.h"

namespace faultlab::server {

/// One estimator on the demonstration of a bench, order 1.
struct EstimateQuestion {
  core::EstimatorMethod method = core::EstimatorMethod::kSwa;
  int window_samples = 100;  ///< K
  int integral_samples = 0;  ///< m, SIA only
  core::SiaMode sia_mode = core::SiaMode::kExact;
  /// White noise added to the estimated channel, in percent of the rms of its variation while
  /// healthy.
  double added_noise_percent = 0.0;
  std::vector<core::Fault> changes;  ///< of ParseChanges
};

/// What the estimator makes of it.
struct EstimateStudy {
  /// Of one parameter of the model.
  struct Parameter {
    std::string name;      ///< "b0d", "b1d", "a1d" or "b0", "b1", "a1"
    double nominal = 0.0;  ///< of the bench's own model
    double changed = 0.0;  ///< with the changes
    /// Of the estimates while healthy, once the window is full: standard deviation and mean; NaN
    /// when no window fills.
    double deviation = 0.0;
    double mean = 0.0;
    /// Of those of the changed rig, once the window holds no sample from before.
    double mean_after = 0.0;
    /// From the change until the estimate has gone nine tenths of its way for the first time;
    /// absent when the change does not stand out from its noise.
    std::optional<double> delay_s;
    std::vector<double> estimates;  ///< one a sample; NaN where there is none
  };
  std::array<Parameter, 3> parameters;
  double fault_at_s = 0.0;
  double added_noise = 0.0;  ///< rms, in the unit of the channel
  double settle_s = 0.0;     ///< (K + m - 1) T: the window then holds no sample of before
};

/// Windows of up to 500 samples, so that the healthy part fills them.
inline constexpr int kStudyWindowMax = 500;

/// Refusals name the query parameter. Cost: some 2 ms.
core::Result<EstimateStudy> StudyEstimates(const core::Bench& bench,
                                           const EstimateQuestion& question);

}  // namespace faultlab::server
