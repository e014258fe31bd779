#pragma once

#include <array>
#include <cstdint>

namespace faultlab::core {

/// Seeded random numbers, the same on every machine and library: xoshiro256++ (Blackman, Vigna
/// 2019) started by splitmix64, normal deviates by the ziggurat of Marsaglia and Tsang (2000).
/// No allocation. Copyable: a copy continues with the same numbers. Not thread-safe.
class Random {
 public:
  explicit Random(std::uint64_t seed);

  std::uint64_t Next();
  /// Uniform in [0, 1), 53 bits.
  double Uniform();
  /// Uniform in [low, high).
  double Uniform(double low, double high);
  /// Uniform in [0, bound). Contract: bound > 0.
  std::uint64_t Below(std::uint64_t bound);
  /// Zero mean, unit variance.
  double Normal();

 private:
  std::array<std::uint64_t, 4> state_;
};

/// A seed for stream `stream` of a run with seed `seed`; the streams of one run do not overlap in
/// practice.
std::uint64_t StreamSeed(std::uint64_t seed, std::uint64_t stream);

}  // namespace faultlab::core
