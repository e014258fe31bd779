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
  double period_s = kSamplePeriodSeconds;
  SiaMode sia_mode = SiaMode::kExact;
  double delta_s = 9.5e-3;  ///< DAC edge to ADC sample, [0, period_s]; used by SiaMode::kExact
  double um_rail_v = kConverterRail_v;  ///< readings at the converter's rail are left out
};

/// The six first-order estimators of kEstimatorShapes, fed with one sample after another.
///   SWA theta = {b0d, b1d, a1d}:  um(k) = b0d uc(k) + b1d uc(k-1) - a1d um(k-1)   (paper Eq. 8)
///   SIA theta = {b0, b1, a1}:     Um/Uc = (b1 s + b0) / (a1 s + 1)               (paper Eq. 6)
/// Samples are told apart by index and time: a repeated one is ignored (estimates age by nothing),
/// missing ones leave empty rows behind, and every row that would straddle the gap stays empty.
/// A non-finite uc_v or um_v makes a window `invalid` until its rows have left.
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
};

}  // namespace faultlab::core
