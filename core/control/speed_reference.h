#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::core {

/// The speed that a rig is to have: between two speeds, by steps, ramps or pseudo-random steps.
struct SpeedReference {
  enum class Shape {
    kSteps,  ///< low for hold_s, then high for hold_s, ..
    kRamp,   ///< from low to high in hold_s, and back
    kPrbs,   ///< low or high by a pseudo-random sequence of 1023 bits of hold_s, around the middle
  };
  Shape shape = Shape::kSteps;
  double low_rad_s = 150.0;  ///< motor shaft
  double high_rad_s = 170.0;
  double hold_s = 2.0;

  double highest() const { return low_rad_s > high_rad_s ? low_rad_s : high_rad_s; }
  double height() const { return highest() - (low_rad_s + high_rad_s - highest()); }
};

/// "steps", "ramp", "prbs".
std::string_view Name(SpeedReference::Shape shape);
std::optional<SpeedReference::Shape> ParseReferenceShape(std::string_view name);

/// Refuses (kInvalid): "low_rad_s" and "high_rad_s" not above 0, "hold_s" below 8 periods or above
/// an hour.
Status Validate(const SpeedReference& reference, double period_s);

/// Reads the reference tick by tick, from its beginning. Contract: Validate(..).ok().
class ReferencePlayer {
 public:
  ReferencePlayer(const SpeedReference& reference, double period_s);

  std::size_t hold_ticks() const { return hold_; }
  /// @param tick  since the beginning
  double At(std::size_t tick) const;

 private:
  SpeedReference reference_;
  std::size_t hold_;
  std::vector<bool> bits_;  ///< of kPrbs
};

}  // namespace faultlab::core
