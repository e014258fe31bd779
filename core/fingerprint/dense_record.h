#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/types/sample.h"

namespace faultlab::core {

/// The channels whose noise tells one record from every other: um, ua, ia, n.
inline constexpr std::array<double Sample::*, 4> kTracedChannels = {
    &Sample::um_v, &Sample::ua_v, &Sample::ia_a, &Sample::n_rpm};

/// A channel at each place of a record: missing ones are NaN, absurd ones are cut to thrice the
/// span of nine in ten.
struct DenseChannel {
  std::vector<float> values;
  float middle = 0.0F;
  float span = 0.0F;  ///< of nine in ten, or of all where those are the same; 0: it does not change
};

/// A record with a place for each period: samples that are left out have one too, at most
/// kGapMost of a gap, so that whoever deletes rows does not move the others.
struct DenseRecord {
  static constexpr std::int64_t kGapMost = 128;

  DenseChannel uc;
  std::array<DenseChannel, kTracedChannels.size()> channels;

  std::size_t size() const { return uc.values.size(); }
};

DenseRecord Dense(std::span<const Sample> samples);

}  // namespace faultlab::core
