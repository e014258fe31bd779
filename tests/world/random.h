#pragma once

#include <cmath>
#include <cstdint>
#include <iterator>
#include <random>

#include "server/lab/lab_types.h"

namespace faultlab::server::lab {

/// Seeded random numbers that are the same on every machine (std's distributions do not guarantee
/// this).
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// 0 .. below-1.
  std::int64_t Below(std::int64_t below) {
    return static_cast<std::int64_t>(engine_() % static_cast<std::uint64_t>(below));
  }
  double Uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  bool Chance(double probability) { return Uniform() < probability; }
  Milliseconds Between(Milliseconds low, Milliseconds high) {
    return low + Milliseconds{Below((high - low).count() + 1)};
  }
  Milliseconds Exponential(Milliseconds mean) {
    const double drawn = -std::log(1.0 - Uniform()) * static_cast<double>(mean.count());
    return Milliseconds{static_cast<std::int64_t>(drawn)};
  }

 private:
  std::mt19937_64 engine_;
};

/// One of the keys; a default one of an empty map.
template <typename Map>
typename Map::key_type AnyKey(Random& random, const Map& map) {
  if (map.empty()) return {};
  auto entry = map.begin();
  std::advance(entry, random.Below(static_cast<std::int64_t>(map.size())));
  return entry->first;
}

}  // namespace faultlab::server::lab
