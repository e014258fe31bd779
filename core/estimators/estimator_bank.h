#pragma once

#include <array>
#include <memory>

#include "core/estimators/sia_mode.h"
#include "core/types/estimate.h"
#include "core/types/frame.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample.h"
#include "core/types/sample_intake.h"

namespace faultlab::core {

struct EstimatorBankOptions {
  double period_s = 0.01;
  SiaMode sia_mode = SiaMode::kExact;
  bool of_row_before = false;  ///< ReadingRules::of_row_before
  double delta_s = 5e-3;       ///< DAC edge to ADC sample, [0, period_s]; used by SiaMode::kExact
  EstimatedChannel channel = EstimatedChannel::kUm;  ///< y of the models below
  double rail = kConverterRail_v;  ///< of its converter; readings at the rail are not used
};

/// The six first-order estimators of kEstimatorShapes, fed with one sample after another.
///   SWA theta = {b0d, b1d, a1d}:  y(k) = b0d uc(k) + b1d uc(k-1) - a1d y(k-1)   (paper Eq. 8)
///   SIA theta = {b0, b1, a1}:     Y/Uc = (b1 s + b0) / (a1 s + 1)               (paper Eq. 6)
/// y is um, or ia on benches whose um is their input times a known gain.
/// Index and time identify a sample. A repeated sample is ignored (estimates do not age), missing
/// samples leave empty slots, and every row that would contain the gap stays empty. A non-finite
/// uc_v or y makes a window `invalid` until its rows have left.
/// Cost: constant per sample, no allocation after construction. Not thread-safe. The same samples
/// give bit-equal estimates.
class EstimatorBank {
 public:
  explicit EstimatorBank(const EstimatorBankOptions& options = {});
  ~EstimatorBank();
  EstimatorBank(EstimatorBank&&) noexcept;
  EstimatorBank& operator=(EstimatorBank&&) noexcept;

  void Push(const Sample& sample, std::array<Estimate<3>, kEstimatorCount>& out);

  const EstimatorBankOptions& options() const { return options_; }

 private:
  struct Windows;

  EstimatorBankOptions options_;
  std::unique_ptr<Windows> windows_;
  double uc_before_v_ = kAbsent;
};

}  // namespace faultlab::core
