#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace faultlab::testing {

/// The first-order model at its nominal values (paper Table 1 through Eq. 4).
inline constexpr double kB0 = 2.3935;
inline constexpr double kB1 = 0.0382;
inline constexpr double kA1 = 0.01807;
inline constexpr double kPeriod_s = 0.01;

struct Record {
  std::vector<double> u;
  std::vector<double> y;
};

/// Random binary input between 2 V and 3 V, each value held `hold` samples.
inline std::vector<double> MakeBinary(int samples, int hold, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<double> u;
  double level = 2.0;
  for (int k = 0; k < samples; ++k) {
    if (k % hold == 0) {
      level = (random() >> 40) % 2 == 0 ? 2.0 : 3.0;
    }
    u.push_back(level);
  }
  return u;
}

/// (b1 s + b0)/(a1 s + 1) behind a hold, read delta after each edge, by its state:
///   w' = (u - w)/a1,  y = b1/a1 u + (b0 - b1/a1) w + offset, white noise on y.
inline Record MakeFirstOrder(const std::vector<double>& u,
                             double delta_s,
                             double noise_v,
                             std::uint64_t seed,
                             double offset_v = 0.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  Record record;
  record.u = u;
  double w = u.front();
  for (double level : u) {
    const double read = level + (w - level) * std::exp(-delta_s / kA1);
    record.y.push_back(kB1 / kA1 * level + (kB0 - kB1 / kA1) * read + offset_v +
                       noise_v * noise(random));
    w = level + (w - level) * std::exp(-kPeriod_s / kA1);
  }
  return record;
}

}  // namespace faultlab::testing
