#pragma once

#include <optional>

#include "core/control/speed_model.h"
#include "core/types/component.h"
#include "core/types/result.h"

namespace faultlab::core {

/// What a drive must know of one rig, healthy or with a fault.
struct DriveModel {
  SpeedModel speed;
  double gain = 1.0;             ///< V of the amplifier's output per V of uc, > 0
  double resistance_ohm = 1.0;   ///< of winding and series resistor
  double ke_v_per_rad_s = 0.0;   ///< voltage of the turning motor
  double input_max_v = 0.0;      ///< highest uc that range and supply allow
  double sustained_rad_s = 0.0;  ///< highest speed at which the winding stays cool enough
  double motor_kept = 0.0;       ///< as speed.kept, of the motor alone, without the amplifier's lag
  double lag_kept = 0.0;         ///< exp(-T / lag)
  double direct = 1.0;           ///< share of the amplifier's gain that acts at once

  /// The highest speed that it can settle at and stands for ever, rad/s.
  double reachable_rad_s() const;
};

struct BelievedFault {
  Component component;
  double value = 0.0;  ///< SI unit
  DriveModel rig;      ///< with this fault
};

/// All that who diagnoses has to tell who drives. Complete: the newest one counts alone.
struct ControlOrder {
  DriveModel healthy;
  double noise_rad_s = 0.0;  ///< standard deviation of a reading, motor shaft
  double delta_s = 0.0;      ///< edge of uc to reading
  /// Named, with a value whose standard error is below a fifth of it, or settled.
  std::optional<BelievedFault> believed{};
  bool alarmed = false;
  bool named = false;  ///< the alarm has a name, sure or not
};

/// Refuses (kInvalid, "control") what no diagnosis can have said: not finite, not positive.
Status Validate(const ControlOrder& order);

}  // namespace faultlab::core
