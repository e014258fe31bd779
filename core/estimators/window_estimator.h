#pragma once

#include <cmath>

#include "core/estimators/row_history.h"
#include "core/estimators/sliding_least_squares.h"

namespace faultlab::core {

/// Rows of a model and the least squares over the newest K of them: the part that SWA and SIA
/// share. `Rows` has kParameters, Row, and these functions, each of which returns the kind of this
/// sample's row:
///   RowKind Push(double u_v, double y_v, Row& row);  // row is set when kValid
///   RowKind PushUnusable();
///   void Break();
template <typename Rows, typename Report = ReportAsSolved<Rows::kParameters>>
class WindowEstimator {
 public:
  static constexpr int kParameters = Rows::kParameters;

  /// The next consecutive sample. Non-finite values make the window invalid.
  const Estimate<kParameters>& Push(double u_v, double y_v) {
    typename Rows::Row row;
    const RowKind kind = rows_.Push(u_v, y_v, row);
    return kind == RowKind::kValid ? least_squares_.Push(row) : least_squares_.PushEmpty(kind);
  }

  /// A sample whose y exists but must not be used (clipped at the converter's rail).
  const Estimate<kParameters>& PushUnusable() {
    return least_squares_.PushEmpty(rows_.PushUnusable());
  }

  /// `samples` were lost before the next one.
  void Skip(int samples) {
    rows_.Break();
    least_squares_.Skip(samples);
  }

  const Estimate<kParameters>& estimate() const { return least_squares_.estimate(); }

 protected:
  using Kernel = SlidingLeastSquares<kParameters, Report>;

  WindowEstimator(const Rows& rows,
                  int window_samples,
                  const ExcitationGate<kParameters>& gate,
                  const Report& report = Report())
      : rows_(rows), least_squares_(window_samples, gate, report) {}

  /// Zero-mean noise of y that adds `per_row` to the sums of every row on average.
  void CompensateNoise(const typename Kernel::Moments::Packed& per_row) {
    least_squares_.CompensateNoise(per_row);
  }

 private:
  Rows rows_;
  Kernel least_squares_;
};

}  // namespace faultlab::core
