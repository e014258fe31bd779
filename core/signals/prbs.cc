#include "core/signals/prbs.h"

#include <array>
#include <bit>
#include <cmath>

#include "core/signals/random.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

// Feedback polynomials x^n + .. + 1 that are primitive over GF(2), one for each order; bit i-1 is
// the coefficient of x^i. Peterson and Weldon, Error-Correcting Codes (1972), appendix C.
constexpr std::uint32_t Taps(std::initializer_list<int> powers) {
  std::uint32_t mask = 0;
  for (const int power : powers) {
    mask |= 1U << static_cast<unsigned>(power - 1);
  }
  return mask;
}

constexpr std::array<std::uint32_t, kPrbsOrderMax + 1> kTaps = {0,
                                                                0,
                                                                0,
                                                                Taps({3, 2}),
                                                                Taps({4, 3}),
                                                                Taps({5, 3}),
                                                                Taps({6, 5}),
                                                                Taps({7, 6}),
                                                                Taps({8, 6, 5, 4}),
                                                                Taps({9, 5}),
                                                                Taps({10, 7}),
                                                                Taps({11, 9}),
                                                                Taps({12, 11, 10, 4}),
                                                                Taps({13, 12, 11, 8}),
                                                                Taps({14, 13, 12, 2}),
                                                                Taps({15, 14}),
                                                                Taps({16, 15, 13, 4}),
                                                                Taps({17, 14}),
                                                                Taps({18, 11}),
                                                                Taps({19, 18, 17, 14}),
                                                                Taps({20, 17})};

// A clock time that equals a sample time up to rounding of k * period belongs to that sample.
constexpr double kClockSlack = 1e-9;

}  // namespace

ShiftRegister::ShiftRegister(int order, std::uint64_t seed) {
  LAB_CHECK(order >= kPrbsOrderMin && order <= kPrbsOrderMax, order);
  taps_ = kTaps[static_cast<std::size_t>(order)];
  mask_ = (1U << static_cast<unsigned>(order)) - 1U;
  content_ = static_cast<std::uint32_t>(1 + Random(seed).Below(mask_));
}

bool ShiftRegister::Step() {
  const auto feedback = static_cast<std::uint32_t>(std::popcount(content_ & taps_)) & 1U;
  content_ = ((content_ << 1U) | feedback) & mask_;
  return feedback != 0;
}

Status Validate(const PrbsSpec& spec, double period_s) {
  if (spec.order < kPrbsOrderMin || spec.order > kPrbsOrderMax) {
    return Refuse(
        "prbs_order_outside", "order", {{"lowest", kPrbsOrderMin}, {"highest", kPrbsOrderMax}});
  }
  if (!(std::isfinite(spec.clock_s) && spec.clock_s >= period_s * (1.0 - kClockSlack))) {
    return Refuse("clock_too_short", "clock_s");
  }
  if (!std::isfinite(spec.low_v)) {
    return Refuse("voltage_not_a_number", "low_v");
  }
  if (!(std::isfinite(spec.high_v) && spec.high_v > spec.low_v)) {
    return Refuse("high_below_low", "high_v");
  }
  return Done{};
}

std::vector<double> MakePrbs(const PrbsSpec& spec, int samples, double period_s) {
  const Status status = Validate(spec, period_s);
  LAB_CHECK(status.ok() && samples >= 0, samples, status.error().message);
  ShiftRegister bits(spec.order, spec.seed);
  std::vector<double> uc_v;
  uc_v.reserve(static_cast<std::size_t>(samples));
  std::int64_t clocked = -1;
  bool bit = false;
  for (int k = 0; k < samples; ++k) {
    const auto clock =
        static_cast<std::int64_t>(std::floor(k * period_s / spec.clock_s + kClockSlack));
    for (; clocked < clock; ++clocked) {
      bit = bits.Step();
    }
    uc_v.push_back(bit ? spec.high_v : spec.low_v);
  }
  return uc_v;
}

}  // namespace faultlab::core
