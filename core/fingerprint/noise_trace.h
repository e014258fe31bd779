#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/types/sample.h"

namespace faultlab::core {

/// The channels whose noise tells one record from every other: um, ua, ia, n.
inline constexpr std::array<double Sample::*, 4> kTracedChannels = {
    &Sample::um_v, &Sample::ua_v, &Sample::ia_a, &Sample::n_rpm};

/// What an adaptive predictor of a channel cannot predict: nearly white noise that no other run has
/// again. Counts of kTraceUnit, in the noise's own standard deviations; at most kTraceMost of them.
/// 0: nothing is known of this sample. Empty: the channel was not measured.
using NoiseTrace = std::vector<std::int8_t>;
inline constexpr int kTraceUnit = 32;
inline constexpr int kTraceMost = 3;

/// Of a record that is kept to be found, stretches with more than noise are left out: what a
/// switched part does to the readings is the same in two runs of one fault. A record that is looked
/// up keeps them, and is cleaned of single outliers instead: nobody can blind it by adding some.
enum class Surprises { kKept, kLeftOut };

/// For each channel y, with the command u:
///   e(k) = y(k) - theta' [1, u(k), .., u(k-3), y(k-1), .., y(k-3)]
/// theta by least squares over the 64 samples around k. e over its root mean square there is the
/// trace: gain, offset and, within 5 %, the period of a record do not change it.
/// Cost: some 0.3 us for a sample and channel; four times that for kKept with outliers.
/// @returns by kTracedChannels, each as long as `samples` or empty
std::array<NoiseTrace, kTracedChannels.size()> TracesOf(std::span<const Sample> samples,
                                                        Surprises surprises);

}  // namespace faultlab::core
