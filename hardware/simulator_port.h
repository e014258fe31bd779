#pragma once

#include <cstdint>

#include "core/types/component.h"

namespace faultlab::hardware {

/// What only a simulator can do: parts without relays, values off the table, a fresh motor.
class SimulatorPort {
 public:
  virtual ~SimulatorPort() = default;

  /// At rest, at nominal values, with this seed.
  virtual void BeginRun(std::uint64_t seed) = 0;
  /// Replaces a part; on a relay board, until the board is switched.
  virtual void Set(core::Component component, double value) = 0;
  /// The part itself changes a little: a capacitor keeps its charge.
  virtual void Drift(core::Component component, double value) = 0;
  /// Puts the relay board's (or the motor's nominal) value back.
  virtual void Clear(core::Component component) = 0;
};

}  // namespace faultlab::hardware
