#include "core/signals/random.h"

#include <bit>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

std::uint64_t SplitMix(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31U);
}

// Marsaglia and Tsang's 128 layers of equal area under exp(-x^2/2).
constexpr int kLayers = 128;
constexpr double kTail = 3.442619855899;  // right edge of the base layer
constexpr double kLayerArea = 9.91256303526217e-3;
constexpr double kTwoToMinus53 = 0x1.0p-53;

struct Ziggurat {
  std::array<double, kLayers + 1> x;  // right edges; x[0] gives the base layer its area
  std::array<double, kLayers + 1> f;  // exp(-x^2/2)

  Ziggurat() {
    const double base = std::exp(-0.5 * kTail * kTail);
    x[0] = kLayerArea / base;
    x[1] = kTail;
    for (std::size_t i = 2; i < kLayers; ++i) {
      x[i] =
          std::sqrt(-2.0 * std::log(kLayerArea / x[i - 1] + std::exp(-0.5 * x[i - 1] * x[i - 1])));
    }
    x[kLayers] = 0.0;
    for (std::size_t i = 0; i <= kLayers; ++i) {
      f[i] = std::exp(-0.5 * x[i] * x[i]);
    }
  }
};

const Ziggurat& Tables() {
  static const Ziggurat tables;
  return tables;
}

}  // namespace

Random::Random(std::uint64_t seed) {
  for (std::uint64_t& word : state_) {
    word = SplitMix(seed);
  }
}

std::uint64_t Random::Next() {
  const std::uint64_t result = std::rotl(state_[0] + state_[3], 23) + state_[0];
  const std::uint64_t t = state_[1] << 17U;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = std::rotl(state_[3], 45);
  return result;
}

double Random::Uniform() {
  return static_cast<double>(Next() >> 11U) * kTwoToMinus53;
}

double Random::Uniform(double low, double high) {
  return low + (high - low) * Uniform();
}

std::uint64_t Random::Below(std::uint64_t bound) {
  LAB_CHECK(bound > 0);
  const std::uint64_t unfair = (0 - bound) % bound;  // 2^64 mod bound: draws below are rejected
  std::uint64_t draw = Next();
  while (draw < unfair) {
    draw = Next();
  }
  return draw % bound;
}

double Random::Normal() {
  const Ziggurat& z = Tables();
  for (;;) {
    const std::uint64_t bits = Next();
    const auto layer = static_cast<std::size_t>(bits & (kLayers - 1));
    const double sign = (bits & kLayers) != 0 ? -1.0 : 1.0;
    const double x = static_cast<double>(bits >> 11U) * kTwoToMinus53 * z.x[layer];
    if (x < z.x[layer + 1]) {
      return sign * x;
    }
    if (layer == 0) {
      double beyond = 0.0;
      double height = 0.0;
      do {  // Marsaglia's tail
        beyond = -std::log(1.0 - Uniform()) / kTail;
        height = -std::log(1.0 - Uniform());
      } while (2.0 * height < beyond * beyond);
      return sign * (kTail + beyond);
    }
    if (z.f[layer + 1] + Uniform() * (z.f[layer] - z.f[layer + 1]) < std::exp(-0.5 * x * x)) {
      return sign * x;
    }
  }
}

std::uint64_t StreamSeed(std::uint64_t seed, std::uint64_t stream) {
  std::uint64_t state = seed ^ (stream * 0xd1342543de82ef95U);
  SplitMix(state);
  return SplitMix(state);
}

}  // namespace faultlab::core
