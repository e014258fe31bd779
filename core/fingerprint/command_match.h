#pragma once

#include <array>
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
  /// @param stride  of kStrides
  std::span<const std::uint64_t> words(std::size_t stride) const {
    return words_[stride - kStrides.front()];
  }
  static constexpr std::array<std::size_t, 4> kStrides = {2, 3, 4, 5};

 private:
  std::vector<float> uc_v_;
  std::vector<float> wave_;
  float still_ = 0.0F;
  std::array<std::vector<std::uint64_t>, kStrides.size()> words_;
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

/// Products of a known and another command's places that FindCommon compares: some 2 ns each.
double CostOfFindCommon(std::size_t known, std::size_t other);

/// Every stretch of at least kAnchor places of `known` that is in `other`, whose rate differs by
/// 5 % at most, or which has every second to fifth of its samples, or each twice: by the signs of
/// the wave first, then by the correlation of the voltages. A command that repeats itself is found
/// at each of its repetitions.
/// @param visit  is told each; false: that is enough
void FindCommon(const Command& known,
                const Command& other,
                const std::function<bool(const CommonStretch&)>& visit);

}  // namespace faultlab::core
