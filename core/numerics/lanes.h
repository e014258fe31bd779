#pragma once

#include <cmath>

namespace faultlab::core {

/// Two doubles in one register: + - * / < ?: work lane by lane, and each lane gives the same bits
/// as a single double.
using Lanes2 = double __attribute__((vector_size(16)));

[[gnu::always_inline]] inline double SquareRoot(double value) {
  return std::sqrt(value);
}
[[gnu::always_inline]] inline Lanes2 SquareRoot(Lanes2 values) {
#ifdef __SSE2__
  return __builtin_ia32_sqrtpd(values);
#else
  return {std::sqrt(values[0]), std::sqrt(values[1])};
#endif
}

[[gnu::always_inline]] inline double Magnitude(double value) {
  return std::abs(value);
}
[[gnu::always_inline]] inline Lanes2 Magnitude(Lanes2 values) {
  using Bits = long long __attribute__((vector_size(16)));
  constexpr long long kAllButSign = 0x7fff'ffff'ffff'ffff;
  return reinterpret_cast<Lanes2>(reinterpret_cast<Bits>(values) & kAllButSign);
}

}  // namespace faultlab::core
