#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/fingerprint/dense_record.h"

namespace faultlab::core {

/// The control voltage of a run, ready to be found in that of another.
class Command {
 public:
  /// Places by which it is found: a shorter command has none.
  static constexpr std::size_t kAnchor = 128;

  explicit Command(const DenseChannel& uc);

  /// Held where it is missing.
  std::span<const float> uc_v() const { return uc_v_; }
  /// uc less its mean over kAnchor places around each.
  std::span<const float> wave() const { return wave_; }
  /// Less than this share of its span is nothing: somebody may have added noise to it.
  float still() const { return still_; }
  /// Of each place, whether the wave is above 0 there and 1 to 63 times `stride` places later: bit
  /// by bit.
  std::vector<std::uint64_t> WordsOf(std::size_t stride) const;
  /// Those of kStride, which are kept: 16 bytes for each place altogether.
  std::span<const std::uint64_t> words() const { return words_; }
  static constexpr std::size_t kStride = 2;

 private:
  std::vector<float> uc_v_;
  std::vector<float> wave_;
  float still_ = 0.0F;
  std::vector<std::uint64_t> words_;
};

/// A stretch of a known command that stands in another one too, with another gain, sign, offset and
/// rate.
struct CommonStretch {
  std::size_t begin = 0;  ///< in the known one
  std::vector<float> at;  ///< of each place from `begin` on, its place in the other one
};

/// Samples of the other command per sample of the known one: with fewer, each of its samples stands
/// at one place alone, and what is between is not known.
inline constexpr double kRateOfFewer = 0.75;

/// What FindCommon spends at least, in ns: on the first look at all places.
double CostOfFindCommon(std::size_t known, std::size_t other);

/// Every stretch of at least kAnchor places of `known` that is in `other`, whose rate differs by
/// 5 % at most, or which has every second to fifth of its samples, or each twice: by the signs of
/// the wave first, then by the correlation of the voltages. A command that repeats itself is found
/// at each of its repetitions.
/// @param ns_left  may be spent; what is spent is subtracted, and below 0 the search ends
/// @param visit    is told each
void FindCommon(const Command& known,
                const Command& other,
                double& ns_left,
                const std::function<void(const CommonStretch&)>& visit);

}  // namespace faultlab::core
