#include "core/control/speed_reference.h"

#include <cmath>
#include <string>

#include "core/signals/prbs.h"

namespace faultlab::core {
namespace {

// A hold is judged by its last quarter.
constexpr int kHoldPeriodsMin = 8;
constexpr double kHoldMaxS = 3600.0;
constexpr int kPrbsOrder = 10;
constexpr std::uint64_t kPrbsSeed = 7;  // a lively beginning: most runs are short

}  // namespace

std::string_view Name(SpeedReference::Shape shape) {
  switch (shape) {
    case SpeedReference::Shape::kSteps:
      return "steps";
    case SpeedReference::Shape::kRamp:
      return "ramp";
    case SpeedReference::Shape::kPrbs:
      return "prbs";
  }
  return "steps";
}

std::optional<SpeedReference::Shape> ParseReferenceShape(std::string_view name) {
  using enum SpeedReference::Shape;
  for (const SpeedReference::Shape shape : {kSteps, kRamp, kPrbs}) {
    if (Name(shape) == name) return shape;
  }
  return std::nullopt;
}

Status Validate(const SpeedReference& reference, double period_s) {
  const auto refuse = [](std::string message, std::string field) {
    return Error{ErrorCode::kInvalid, std::move(message), std::move(field), "control_reference"};
  };
  const auto possible = [](double speed) { return speed > 0.0 && std::isfinite(speed); };
  if (!possible(reference.low_rad_s) || !possible(reference.high_rad_s)) {
    return refuse("a reference is two speeds above 0",
                  possible(reference.low_rad_s) ? "high_rad_s" : "low_rad_s");
  }
  if (!(reference.hold_s >= kHoldPeriodsMin * period_s && reference.hold_s <= kHoldMaxS)) {
    return refuse("a speed is held for at least " + std::to_string(kHoldPeriodsMin) +
                      " periods of the bench, and for at most an hour",
                  "hold_s");
  }
  return Done{};
}

ReferencePlayer::ReferencePlayer(const SpeedReference& reference, double period_s)
    : reference_(reference),
      hold_(static_cast<std::size_t>(std::lround(reference.hold_s / period_s))) {
  if (reference.shape != SpeedReference::Shape::kPrbs) return;
  ShiftRegister bits(kPrbsOrder, kPrbsSeed);
  for (std::uint32_t i = 0; i < bits.period(); ++i) bits_.push_back(bits.Step());
}

double ReferencePlayer::At(std::size_t tick) const {
  const std::size_t hold = tick / hold_;
  const auto [shape, low, high, hold_s] = reference_;
  const bool odd = hold % 2 == 1;
  if (shape == SpeedReference::Shape::kPrbs) return bits_[hold % bits_.size()] ? high : low;
  if (shape == SpeedReference::Shape::kSteps) return odd ? high : low;
  const double share = static_cast<double>(tick % hold_) / static_cast<double>(hold_);
  return low + (high - low) * (odd ? 1.0 - share : share);
}

}  // namespace faultlab::core
