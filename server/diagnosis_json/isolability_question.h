#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/isolability/isolability.h"
#include "core/signals/excitation.h"
#include "core/types/calibration.h"
#include "core/types/result.h"

namespace faultlab::server {

/// A fault set, its rig, and the channels and the time to be used, as a person states them.
struct IsolabilityQuestion {
  const core::Bench* bench = nullptr;  ///< never null
  std::string
      profile;  ///< a simulator of the bench for a rig without a calibration; empty: the usual one
  std::optional<core::Calibration> calibration;  ///< of one rig; then `profile` is not used
  core::ExcitationSpec excitation = core::PrbsSpec{};
  std::string excitation_name = "prbs";  ///< for ToText
  std::string channels;                  ///< um or all; empty: um, where estimators use it
  int window_samples = 100;              ///< of the fault
  std::optional<double> um_noise_v;      ///< replaces the rig's own
  std::vector<core::FaultSize> faults;   ///< empty: those of the bench, see FaultsOf
};

/// What `channels` means.
core::Result<core::Channels> ChannelsOf(const IsolabilityQuestion& question);

/// Refuses (kInvalid, field = the member's name) values that do not match the comments above.
core::Result<core::IsolabilityOptions> ToOptions(const IsolabilityQuestion& question);

/// The question in a line, for a figure.
std::string ToText(const IsolabilityQuestion& question);

}  // namespace faultlab::server
