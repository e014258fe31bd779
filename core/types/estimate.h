#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

namespace faultlab::core {

/// How an estimate may be used.
enum class EstimateStatus : std::uint8_t {
  kExcited,     ///< full rank and well conditioned: use it
  kWeak,        ///< standard errors above the declared tolerance: report with its error
  kNotExcited,  ///< no information: theta is the last usable one, see age_samples
  kInvalid,     ///< a non-finite sample lies in the window, or the window is not yet full
};

constexpr std::string_view Name(EstimateStatus status) {
  switch (status) {
    case EstimateStatus::kExcited:
      return "excited";
    case EstimateStatus::kWeak:
      return "weak";
    case EstimateStatus::kNotExcited:
      return "not_excited";
    case EstimateStatus::kInvalid:
      return "invalid";
  }
  return "?";
}

/// P parameters with their errors.
template <int P>
struct Estimate {
  std::array<double, P> theta{};  ///< SWA: b0d.. (volt/volt) then a1d..; SIA: b0.. (s^i) then a1..
  std::array<double, P> sigma{};  ///< standard errors, NaN when not excited
  double sse = 0.0;               ///< sum of squared equation errors in the window (V^2 or (V s)^2)
  double condition = 0.0;         ///< condition number of the normal matrix; huge when singular
  EstimateStatus status = EstimateStatus::kInvalid;
  std::int32_t age_samples = 0;  ///< samples since theta was last computed, 0 = this sample
};

/// As it may be shown and written: NaN for every parameter that is not known. Of an invalid one
/// that is all; of one whose time constant the sampling does not resolve (an infinite error of the
/// second parameter, see SiaExactMap) all but the gain.
template <int P>
Estimate<P> Shown(Estimate<P> estimate) {
  static_assert(P > 1);
  std::size_t known = P;
  if (std::isinf(estimate.sigma[1])) known = 1;
  if (estimate.status == EstimateStatus::kInvalid) known = 0;
  for (std::size_t i = known; i < P; ++i) {
    estimate.theta[i] = estimate.sigma[i] = std::numeric_limits<double>::quiet_NaN();
  }
  return estimate;
}

}  // namespace faultlab::core
