#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace faultlab::core {

/// The control voltage of a run, ready to be found in that of another.
class Command {
 public:
  /// Samples by which a place is found: a shorter command has none.
  static constexpr std::size_t kAnchor = 128;

  explicit Command(std::vector<float> uc_v);

  std::span<const float> uc_v() const { return uc_v_; }
  /// uc less its mean over kAnchor samples around each.
  std::span<const float> wave() const { return wave_; }
  /// Less than this is 0 in the wave.
  float still() const { return still_; }
  /// Of each place, whether the wave is above 0 there and 2, 4, .. 126 samples later: bit by bit.
  std::span<const std::uint64_t> words() const { return words_; }

 private:
  std::vector<float> uc_v_;
  std::vector<float> wave_;
  float still_ = 0.0F;
  std::vector<std::uint64_t> words_;
};

/// A stretch of a known command that stands in another one too, with another gain, offset and rate.
struct CommonStretch {
  std::size_t begin = 0;  ///< in the known one
  std::vector<float> at;  ///< of each sample from `begin` on, its place in the other one
};

/// Every stretch of at least kAnchor samples of `known` that is in `other`, whose rate differs by
/// 5 % at most: by the signs of the wave first, then by the correlation of the voltages. A command
/// that repeats itself is found at each of its repetitions.
/// Cost: some 0.1 us for each sample of `known` and each 70 of `other`.
std::vector<CommonStretch> FindCommon(const Command& known, const Command& other);

}  // namespace faultlab::core
