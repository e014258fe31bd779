#include "core/estimators/estimator_bank.h"

#include <utility>

#include "core/estimators/first_order_windows.h"
#include "core/estimators/sia.h"
#include "core/estimators/swa.h"
#include "core/types/check.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {
namespace {

/// The kind of row that each estimator uses.
constexpr std::array<std::size_t, kEstimatorCount> kRowOf = {0, 0, 0, 1, 2, 2};

const EstimatorShape& ShapeOf(EstimatorId id) {
  return kEstimatorShapes[static_cast<std::size_t>(id)];
}

std::array<ExcitationGate<3>, kEstimatorCount> Gates() {
  std::array<ExcitationGate<3>, kEstimatorCount> gates;
  for (std::size_t i = 0; i < gates.size(); ++i) {
    gates[i] = kEstimatorShapes[i].integral_samples == 0 ? SwaGate<1>() : SiaGate<1>();
  }
  return gates;
}

SiaRows<1> RowsOf(EstimatorId id, double period_s) {
  return {ShapeOf(id).integral_samples, period_s};
}

}  // namespace

/// Three kinds of rows for six windows: the rows of SWA, and the rows of SIA with either integral.
struct EstimatorBank::Windows {
  explicit Windows(const EstimatorBankOptions& options)
      : intake(options.period_s, options.rail, options.channel),
        sia_short(RowsOf(EstimatorId::kSia20x5, options.period_s)),
        sia_long(RowsOf(EstimatorId::kSia100x20, options.period_s)),
        least_squares(Gates(), {options.sia_mode, {options.period_s, options.delta_s}}) {}

  void Skip(int samples) {
    swa.Break();
    sia_short.Break();
    sia_long.Break();
    least_squares.Skip(samples);
  }

  void Push(double u_v, double y_v) {
    rows[0].kind = swa.Push(u_v, y_v, rows[0].value);
    rows[1].kind = sia_short.Push(u_v, y_v, rows[1].value);
    rows[2].kind = sia_long.Push(u_v, y_v, rows[2].value);
    least_squares.Push(rows, kRowOf);
  }

  void PushUnusable() {
    rows[0].kind = swa.PushUnusable();
    rows[1].kind = sia_short.PushUnusable();
    rows[2].kind = sia_long.PushUnusable();
    least_squares.Push(rows, kRowOf);
  }

  SampleIntake intake;
  SwaRows<1> swa;
  SiaRows<1> sia_short;
  SiaRows<1> sia_long;
  FirstOrderWindows least_squares;
  std::array<FirstOrderWindows::Row, 3> rows;
};

EstimatorBank::EstimatorBank(const EstimatorBankOptions& options) : options_(options) {
  LAB_CHECK(options.period_s > 0.0, options.period_s);
  LAB_CHECK(options.delta_s >= 0.0 && options.delta_s <= options.period_s, options.delta_s);
  windows_ = std::make_unique<Windows>(options);
}

EstimatorBank::~EstimatorBank() = default;
EstimatorBank::EstimatorBank(EstimatorBank&&) noexcept = default;
EstimatorBank& EstimatorBank::operator=(EstimatorBank&&) noexcept = default;

void EstimatorBank::Push(const Sample& sample, std::array<Estimate<3>, kEstimatorCount>& out) {
  const SampleStep step = windows_->intake.Classify(sample);
  if (options_.of_row_before && step.use != SampleUse::kIgnore) {
    Sample moved = sample;
    const double before_v = std::exchange(uc_before_v_, sample.uc_v);
    moved.uc_v = step.missing > 0 ? kAbsent : before_v;
    Feed(step, moved, *windows_, options_.channel);
  } else {
    Feed(step, sample, *windows_, options_.channel);
  }
  out = windows_->least_squares.estimates();
}

}  // namespace faultlab::core
