#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "core/types/sample.h"
#include "core/types/structure.h"

namespace faultlab::core {

/// The properties of a channel that the first-order estimators can fit.
struct EstimatedChannelInfo {
  std::string_view name;    ///< "um"
  std::string_view symbol;  ///< "U_{m}", as figures write it
  std::string_view unit;    ///< "V"
  double Sample::*reading;
  int row;  ///< in SampledModel and in Observation::y; bit of Observation::mask
};

/// By EstimatedChannel.
inline constexpr std::array<EstimatedChannelInfo, 3> kEstimatedChannels = {
    {{"um", "U_{m}", "V", &Sample::um_v, 0},
     {"ia", "I_{a}", "A", &Sample::ia_a, 1},
     {"n", "n", "rpm", &Sample::n_rpm, 2}}};

constexpr const EstimatedChannelInfo& InfoOf(EstimatedChannel channel) {
  return kEstimatedChannels[static_cast<std::size_t>(channel)];
}

/// The reading of a channel in a sample, in its unit.
constexpr double ReadingOf(const Sample& sample, EstimatedChannel channel) {
  return sample.*InfoOf(channel).reading;
}
constexpr double& ReadingOf(Sample& sample, EstimatedChannel channel) {
  return sample.*InfoOf(channel).reading;
}

}  // namespace faultlab::core
