#include "hardware/delta_watch.h"
#include "core/types/number_text.h"

#include <algorithm>
#include <cmath>

namespace faultlab::hardware {
namespace {

std::string Milliseconds(double seconds) {
  return core::Format("%.2f ms", seconds * 1e3);
}

}  // namespace

DeltaWatch::DeltaWatch(double described_s, double period_s)
    : described_s_(described_s),
      samples_a_second_(std::max<std::int64_t>(1, std::llround(1.0 / period_s))) {}

std::optional<RigEvent> DeltaWatch::Push(const core::Sample& sample) {
  if (said_ || std::isnan(sample.delta_s)) return std::nullopt;
  sum_s_ += sample.delta_s;
  if (++samples_ < samples_a_second_) return std::nullopt;
  const double mean_s = sum_s_ / static_cast<double>(samples_);
  samples_ = 0;
  sum_s_ = 0.0;
  if (std::abs(mean_s - described_s_) <= kDeltaTolerance) return std::nullopt;
  said_ = true;
  return RigEvent{.kind = RigEventKind::kDeltaStrays,
                  .index = sample.index,
                  .value = mean_s,
                  .text = "the converters were read " + Milliseconds(mean_s) +
                          " after the drive, not " + Milliseconds(described_s_) +
                          ": set delta_ms to the measured time, or find what delays the board"};
}

}  // namespace faultlab::hardware
