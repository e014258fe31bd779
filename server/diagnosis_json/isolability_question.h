#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/isolability/isolability.h"
#include "core/signals/excitation.h"
#include "core/types/calibration.h"
#include "core/types/result.h"

namespace faultlab::server {

/// A fault set, the rig it would be switched on, and what one would look at, as a person writes it.
struct IsolabilityQuestion {
  std::string profile = "bench";  ///< bench or multisim: a rig that nobody has calibrated
  std::optional<core::Calibration> calibration;  ///< of one rig; then `profile` says nothing
  core::ExcitationSpec excitation = core::PrbsSpec{};
  std::string excitation_name = "prbs";  ///< for ToText
  std::string channels = "um";           ///< um or all
  int window_samples = 100;              ///< of the fault
  std::optional<double> um_noise_v;      ///< in the place of the rig's own
  std::vector<core::FaultSize> faults;   ///< empty: the paper's 18
};

/// Refuses (kInvalid, field = the member's name) what is not as above.
core::Result<core::IsolabilityOptions> ToOptions(const IsolabilityQuestion& question);

/// The question in a line, for a figure.
std::string ToText(const IsolabilityQuestion& question);

}  // namespace faultlab::server
