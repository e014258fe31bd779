#include "core/fingerprint/dense_record.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/types/sample_intake.h"

namespace faultlab::core {
namespace {

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();

/// The places of the samples, and how many there are.
std::vector<std::size_t> PlacesOf(std::span<const Sample> samples) {
  std::vector<std::size_t> places;
  places.reserve(samples.size());
  std::size_t next = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (k > 0) {
      const std::int64_t gap = samples[k].index - samples[k - 1].index;
      next += static_cast<std::size_t>(std::clamp<std::int64_t>(gap, 1, DenseRecord::kGapMost));
    }
    places.push_back(next);
  }
  return places;
}

float QuantileOf(std::vector<float>& values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, at);
  return *at;
}

DenseChannel ChannelOf(std::span<const Sample> samples,
                       std::span<const std::size_t> places,
                       double Sample::*channel) {
  DenseChannel dense;
  dense.values.assign(places.empty() ? 0 : places.back() + 1, kMissing);
  std::vector<float> known;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double value = samples[k].*channel;
    if (!IsPlausible(value)) continue;
    dense.values[places[k]] = static_cast<float>(value);
    known.push_back(static_cast<float>(value));
  }
  if (known.empty()) return dense;
  dense.middle = QuantileOf(known, 0.5);
  float low = dense.middle;
  float high = dense.middle;
  for (const double left_out : {0.05, 0.005, 0.0}) {  // a step may be short
    if (low < high) break;
    low = QuantileOf(known, left_out);
    high = QuantileOf(known, 1.0 - left_out);
  }
  dense.span = high - low;
  for (float& value : dense.values) {
    if (!std::isnan(value)) value = std::clamp(value, low - dense.span, high + dense.span);
  }
  return dense;
}

}  // namespace

DenseRecord Dense(std::span<const Sample> samples) {
  const std::vector<std::size_t> places = PlacesOf(samples);
  DenseRecord record;
  record.uc = ChannelOf(samples, places, &Sample::uc_v);
  for (std::size_t c = 0; c < kTracedChannels.size(); ++c) {
    record.channels[c] = ChannelOf(samples, places, kTracedChannels[c]);
  }
  return record;
}

}  // namespace faultlab::core
