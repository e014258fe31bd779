#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/types/check.h"

namespace faultlab::core {

/// Entries of a packed lower triangle, row by row: (0,0) (1,0) (1,1) (2,0) ..
constexpr int PackedSize(int rows) {
  return rows * (rows + 1) / 2;
}
constexpr std::size_t PackedIndex(int row, int column) {
  return static_cast<std::size_t>(row * (row + 1) / 2 + column);
}

/// The content of one slot of a window.
enum class RowKind : std::uint8_t {
  kEmpty,    ///< no row for this sample (gap, clipped reading, start); not counted
  kValid,    ///< a row of the sums
  kInvalid,  ///< contains a non-finite sample: the window is invalid until it leaves
};

/// Sums of products z z' over the newest `window` slots, z in R^Q, lower triangle packed.
/// Constant work per sample: the new products are added, the leaving ones subtracted. A shadow
/// accumulator restarts at every block of `window` slots; at the end of the block it contains
/// exactly the window and is copied over the sums. Therefore rounding errors do not accumulate
/// (1e-11 after 1e8 samples), and the effect of a glitch is gone after two windows at most.
/// Source: running sums against batch sums, tests/core/estimators/sliding_moments_test.cc.
template <int Q>
class SlidingMoments {
 public:
  static constexpr int kRow = Q;
  using Row = std::array<double, Q>;
  using Packed = std::array<double, PackedSize(Q)>;

  /// Throws ContractError unless window >= 1.
  explicit SlidingMoments(int window)
      : slots_(CheckedSize(window)), kinds_(slots_.size()), unseen_(window) {}

  void Push(const Row& row) {
    Packed entering;
    std::size_t p = 0;
    for (std::size_t i = 0; i < Q; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        entering[p++] = row[i] * row[j];
      }
    }
    // Copies, and one loop each: without aliasing the compiler can vectorise them.
    const Packed leaving = slots_[at_];
    slots_[at_] = entering;
    for (std::size_t n = 0; n < entering.size(); ++n) {
      sums_[n] += entering[n] - leaving[n];
    }
    for (std::size_t n = 0; n < entering.size(); ++n) {
      shadow_[n] += entering[n];
    }
    Advance(RowKind::kValid);
  }

  /// A slot without a row: kEmpty or kInvalid.
  void PushEmpty(RowKind kind) {
    Packed& slot = slots_[at_];
    for (std::size_t n = 0; n < slot.size(); ++n) {
      sums_[n] -= slot[n];
    }
    slot = Packed{};
    Advance(kind);
  }

  /// Returns to the state before the first push.
  void Clear() {
    sums_ = shadow_ = Packed{};
    slots_.assign(slots_.size(), Packed{});
    kinds_.assign(kinds_.size(), RowKind::kEmpty);
    at_ = 0;
    rows_ = invalid_ = 0;
    unseen_ = window();
  }

  const Packed& sums() const { return sums_; }
  int window() const { return static_cast<int>(slots_.size()); }
  int rows() const { return rows_; }        ///< valid rows in the window
  int invalid() const { return invalid_; }  ///< invalid slots in the window
  bool full() const { return unseen_ == 0; }

 private:
  static std::size_t CheckedSize(int window) {
    LAB_CHECK(window >= 1, window);
    return static_cast<std::size_t>(window);
  }

  void Advance(RowKind entering) {
    const RowKind leaving = kinds_[at_];
    if (entering != leaving) {
      kinds_[at_] = entering;
      rows_ += (entering == RowKind::kValid) - (leaving == RowKind::kValid);
      invalid_ += (entering == RowKind::kInvalid) - (leaving == RowKind::kInvalid);
    }
    unseen_ -= unseen_ > 0;
    if (++at_ == slots_.size()) {
      at_ = 0;
      sums_ = shadow_;
      shadow_ = Packed{};
    }
  }

  Packed sums_{};
  Packed shadow_{};
  std::vector<Packed> slots_;  ///< products, so that what was added is subtracted
  std::vector<RowKind> kinds_;
  std::size_t at_ = 0;
  int rows_ = 0;
  int invalid_ = 0;
  int unseen_;  ///< slots that no sample has reached yet
};

}  // namespace faultlab::core
