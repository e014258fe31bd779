#include "tests/core/fingerprint/disguise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr std::array<double Sample::*, 4> kReadings = {
    &Sample::um_v, &Sample::ua_v, &Sample::ia_a, &Sample::n_rpm};

double Interpolated(const std::vector<Sample>& record, double at, double Sample::*channel) {
  const auto left = static_cast<std::size_t>(at);
  const double share = at - std::floor(at);
  const double there = record[left].*channel;
  return share == 0.0 ? there : (1.0 - share) * there + share * record[left + 1].*channel;
}

struct Span {
  double low = 0.0;
  double high = 0.0;
};

Span SpanOf(const std::vector<Sample>& record, double Sample::*channel) {
  Span span{record.front().*channel, record.front().*channel};
  for (const Sample& sample : record) {
    span.low = std::min(span.low, sample.*channel);
    span.high = std::max(span.high, sample.*channel);
  }
  return span;
}

}  // namespace

std::vector<Sample> Dress(const std::vector<Sample>& record,
                          const Disguise& disguise,
                          const OwnNoise& own,
                          double period_s,
                          Random& random) {
  std::vector<Sample> copy(disguise.samples);
  for (std::size_t k = 0; k < copy.size(); ++k) {
    const double at = static_cast<double>(disguise.from) + disguise.rate * static_cast<double>(k);
    LAB_CHECK(at <= static_cast<double>(record.size() - 1), at, record.size());
    copy[k].index = static_cast<std::int64_t>(k);
    copy[k].t_s = static_cast<double>(k) * period_s;
    copy[k].uc_v = disguise.command_scale * Interpolated(record, at, &Sample::uc_v);
    for (std::size_t c = 0; c < kReadings.size(); ++c) {
      copy[k].*kReadings[c] =
          Interpolated(record, at, kReadings[c]) + disguise.noise * own[c] * random.Normal();
    }
  }
  for (double Sample::*channel : kReadings) {
    const Span span = SpanOf(copy, channel);
    const double width = span.high - span.low;
    const double step = width / static_cast<double>((1 << disguise.bits) - 1);
    for (Sample& sample : copy) {
      double& reading = sample.*channel;
      if (disguise.bits > 0) reading = span.low + step * std::round((reading - span.low) / step);
      reading = disguise.scale * reading + disguise.offset * width;
    }
    for (int k = 0; k < disguise.outliers; ++k) {
      copy[random.Below(copy.size())].*channel = disguise.scale * span.high + width;
    }
  }
  if (disguise.um_alone) {
    for (Sample& sample : copy) sample.ua_v = sample.ia_a = sample.n_rpm = kAbsent;
  }
  return copy;
}

Disguise DrawDisguise(std::size_t record, std::size_t samples, double strength, Random& random) {
  const auto tossed = [&random] { return random.Below(2) == 0; };
  Disguise disguise;
  disguise.samples = samples;
  if (tossed()) disguise.rate = 1.0 + 0.05 * strength * random.Uniform(-1.0, 1.0);
  if (tossed()) disguise.scale = std::exp(strength * random.Uniform(-0.7, 0.7));
  if (tossed()) disguise.command_scale = std::exp(strength * random.Uniform(-0.7, 0.7));
  if (tossed()) disguise.offset = strength * random.Uniform(-1.0, 1.0);
  if (tossed()) disguise.noise = 2.0 * strength;
  if (tossed()) disguise.bits = 16 - static_cast<int>(std::lround(8.0 * strength));
  if (tossed()) disguise.um_alone = true;
  const double needed = static_cast<double>(samples) * disguise.rate + 2.0;
  LAB_CHECK(needed < static_cast<double>(record), needed, record);
  disguise.from = random.Below(record - static_cast<std::size_t>(std::ceil(needed)));
  return disguise;
}

}  // namespace faultlab::core
