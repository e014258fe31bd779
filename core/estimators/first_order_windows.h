#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/estimators/excitation_gate.h"
#include "core/estimators/sia_report.h"
#include "core/estimators/sliding_moments.h"
#include "core/numerics/lanes.h"
#include "core/types/estimate.h"
#include "core/types/frame.h"

namespace faultlab::core {

/// The six windows of kEstimatorShapes, each a SlidingLeastSquares<3> with its own gate and report,
/// computed two by two in the lanes of a register: the same results, bit for bit, at less than half
/// the cost. Keeps rows instead of their products, which takes a third of the memory; this matters
/// when one process serves thousands of rigs. Allocates only when constructed. Not thread-safe.
class FirstOrderWindows {
 public:
  /// The row of a window for one sample; `value` is used only for RowKind::kValid.
  struct Row {
    std::array<double, 4> value{};  ///< phi1 phi2 phi3 y
    RowKind kind = RowKind::kEmpty;
  };

  /// @param gates   of the six windows
  /// @param report  of the windows with an integral (SIA); the others report the solution itself
  FirstOrderWindows(const std::array<ExcitationGate<3>, kEstimatorCount>& gates,
                    const SiaReport<3>& report);

  /// One sample: window i takes rows[row_of[i]].
  void Push(std::span<const Row> rows, const std::array<std::size_t, kEstimatorCount>& row_of);
  /// `samples` were lost; they leave empty slots.
  void Skip(int samples);

  const std::array<Estimate<3>, kEstimatorCount>& estimates() const { return estimates_; }

 private:
  struct Window {
    std::vector<std::array<double, 4>> slots;  ///< rows, zeros where there is none
    std::vector<RowKind> kinds;
    std::size_t at = 0;
    int rows = 0;     ///< valid ones
    int invalid = 0;  ///< invalid slots
    int unseen = 0;   ///< slots that no sample has reached yet
    int rows_min = 0;
    ExcitationGate<3> gate;

    void SetKind(RowKind kind);
    bool usable() const { return invalid == 0 && unseen == 0 && rows >= rows_min; }
  };
  /// Sums and tolerances of two windows, one in each lane.
  struct Pair {
    std::array<Lanes2, 10> sums{};
    std::array<Lanes2, 10> shadow{};
    Lanes2 per_freedom{};  ///< 1 / (rows - 3)
    std::array<Lanes2, 3> absolute{};
    Lanes2 relative{};
  };
  static constexpr std::size_t kPairs = kEstimatorCount / 2;
  static_assert(kEstimatorCount % 2 == 0);

  void PushPair(std::size_t pair, const Row& first, const Row& second);
  void Solve(std::size_t pair);
  void Advance(std::size_t at);
  void Lose(std::size_t at);
  void Clear(std::size_t at);
  bool ReportsExact(std::size_t at) const {
    return report_.mode == SiaMode::kExact && kEstimatorShapes[at].integral_samples > 0;
  }

  SiaReport<3> report_;
  std::array<Pair, kPairs> pairs_;
  std::array<Window, kEstimatorCount> windows_;
  std::array<Estimate<3>, kEstimatorCount> estimates_;
};

}  // namespace faultlab::core
