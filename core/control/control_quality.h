#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "core/control/speed_reference.h"

namespace faultlab::core {

/// Without a fault a control is judged from so long after its beginning on.
inline constexpr double kControlRunInS = 4.5;

/// How well a reference was kept. The last three are of references that hold a speed: 0 and nothing
/// of a ramp.
struct ControlQuality {
  double iae_rad = 0.0;              ///< integral of |reference - speed|
  double late_iae_rad = 0.0;         ///< of it what comes later than two holds
  double overshoot_percent = 0.0;    ///< beyond a step, of its height; the largest
  std::optional<double> settling_s;  ///< until 5 % of the last step's height are never left again
  double steady_error_rad_s = 0.0;   ///< mean over the last quarter of each hold, the largest
};

struct ControlledStretch {
  std::span<const double> reference_rad_s;  ///< of each sample
  std::span<const double> speed_rad_s;      ///< as long; not finite: not known
  std::size_t control_from = 0;             ///< sample of the reference's beginning
  std::size_t from = 0;                     ///< judged from here on, not before it
  double period_s = 0.01;
};

/// Contract: control_from <= from <= size.
ControlQuality QualityOf(const SpeedReference& reference, const ControlledStretch& stretch);

}  // namespace faultlab::core
