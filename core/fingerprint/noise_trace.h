#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/fingerprint/dense_record.h"

namespace faultlab::core {

/// What a local fit of a channel cannot explain: nearly white noise that no other run has again.
/// Counts of kTraceUnit, in the noise's own standard deviations; at most kTraceMost of them. 0:
/// nothing is known of this sample. Empty: the channel was not measured, or does not change.
using NoiseTrace = std::vector<std::int8_t>;
inline constexpr int kTraceUnit = 32;
inline constexpr int kTraceMost = 3;
using NoiseTraces = std::array<NoiseTrace, kTracedChannels.size()>;

/// Of a record that is kept to be found, stretches with more than noise are left out: what a
/// switched part does to the readings is the same in two runs of one fault. A record that is looked
/// up keeps them, and is cleaned of single outliers instead: nobody can blind it by adding some.
enum class Surprises { kKept, kLeftOut };

/// For each channel y, with the command u:
///   e(k) = y(k) - theta' [1, u(k), .., u(k-3), y(k-1), .., y(k-3)]
/// theta by least squares over the 64 samples around k. e over its root mean square there is the
/// trace: gain, sign, offset and, within 5 %, the period of a record do not change it.
/// Cost: some 0.3 us for a sample and channel; four times that for kKept with outliers.
/// @returns by kTracedChannels, each as long as the record or empty
NoiseTraces TracesOf(const DenseRecord& record, Surprises surprises);

}  // namespace faultlab::core
