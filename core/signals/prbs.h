#pragma once

#include <cstdint>
#include <vector>

#include "core/types/excitation_spec.h"
#include "core/types/result.h"

namespace faultlab::core {

inline constexpr int kPrbsOrderMin = 3;
inline constexpr int kPrbsOrderMax = 20;

/// Fibonacci shift register with primitive feedback polynomial: period 2^order - 1.
class ShiftRegister {
 public:
  /// Contract: kPrbsOrderMin <= order <= kPrbsOrderMax.
  ShiftRegister(int order, std::uint64_t seed);

  /// The next bit.
  bool Step();
  std::uint32_t content() const { return content_; }
  std::uint32_t period() const { return mask_; }

 private:
  std::uint32_t content_;
  std::uint32_t taps_;
  std::uint32_t mask_;
};

/// Refuses and names the field: order, clock_s, low_v, high_v.
Status Validate(const PrbsSpec& spec, double period_s);
/// samples [samples], volt. The bit of sample k is the one of clock floor(k period / clock).
/// Contract: Validate(spec, period_s).ok() and samples >= 0.
std::vector<double> MakePrbs(const PrbsSpec& spec, int samples, double period_s);

}  // namespace faultlab::core
