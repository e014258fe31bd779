#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/types/check.h"

namespace faultlab::core {

/// Q(z) x = x(k-1) + .. + x(k-m) and D(z) x = x(k) - x(k-m) of one signal, with constant work per
/// sample. A shadow sum restarts every m samples, as in SlidingMoments, and removes accumulated
/// rounding.
/// Source: paper Eq. (18)-(21), without the factor T.
class SlidingIntegral {
 public:
  struct Output {
    double integral;    ///< Q(z) x(k)
    double difference;  ///< (1 - z^-m) x(k)
  };

  explicit SlidingIntegral(int length) : ring_(CheckedSize(length)) {}

  Output Push(double x) {
    const double oldest = ring_[at_];
    const Output out{sum_, x - oldest};
    sum_ += x - oldest;
    shadow_ += x;
    ring_[at_] = x;
    if (++at_ == ring_.size()) {
      at_ = 0;
      sum_ = shadow_;
      shadow_ = 0.0;
    }
    return out;
  }

  int length() const { return static_cast<int>(ring_.size()); }

 private:
  static std::size_t CheckedSize(int length) {
    LAB_CHECK(length >= 1, length);
    return static_cast<std::size_t>(length);
  }

  std::vector<double> ring_;
  double sum_ = 0.0;
  double shadow_ = 0.0;
  std::size_t at_ = 0;
};

/// rho_j(z) x(k) = T^(n-j) Q^(n-j) (1 - z^-m)^j x(k) for j = 0 .. n = Order: the result of n nested
/// sliding integrals for the j-th derivative of x (paper Eq. (23)). Uses samples up to n m back.
template <int Order>
class NestedIntegrals {
 public:
  NestedIntegrals(int length, double period_s)
      : integrals_(PackedSizeOf(Order), SlidingIntegral(length)) {
    double power = 1.0;
    for (int j = Order; j >= 0; --j) {
      scale_[static_cast<std::size_t>(j)] = power;
      power *= period_s;
    }
  }

  std::array<double, Order + 1> Push(double x) {
    // Level l holds the l + 1 words of l operators, ordered by the number of differences.
    std::array<double, Order + 1> words{};
    words[0] = x;
    std::size_t used = 0;
    for (int level = 0; level < Order; ++level) {
      double last_difference = 0.0;
      for (int j = 0; j <= level; ++j) {
        double& word = words[static_cast<std::size_t>(j)];
        const SlidingIntegral::Output out = integrals_[used++].Push(word);
        word = out.integral;
        last_difference = out.difference;
      }
      words[static_cast<std::size_t>(level + 1)] = last_difference;
    }
    for (std::size_t j = 0; j < words.size(); ++j) {
      words[j] *= scale_[j];
    }
    return words;
  }

  int reach_samples() const { return Order * integrals_.front().length(); }

 private:
  static constexpr std::size_t PackedSizeOf(int order) {
    return static_cast<std::size_t>(order * (order + 1) / 2);
  }

  std::vector<SlidingIntegral> integrals_;
  std::array<double, Order + 1> scale_{};
};

}  // namespace faultlab::core
