#include "core/estimators/estimator_bank.h"

#include "core/estimators/sample_intake.h"
#include "core/estimators/sia.h"
#include "core/estimators/swa.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

const EstimatorShape& ShapeOf(EstimatorId id) {
  return kEstimatorShapes[static_cast<std::size_t>(id)];
}

Swa<1> MakeSwa(EstimatorId id) {
  SwaOptions<1> options;
  options.window_samples = ShapeOf(id).window_samples;
  return Swa<1>(options);
}

Sia<1> MakeSia(EstimatorId id, const EstimatorBankOptions& bank) {
  SiaOptions<1> options;
  options.window_samples = ShapeOf(id).window_samples;
  options.integral_samples = ShapeOf(id).integral_samples;
  options.period_s = bank.period_s;
  options.mode = bank.sia_mode;
  options.delta_s = bank.delta_s;
  return Sia<1>(options);
}

}  // namespace

struct EstimatorBank::Windows {
  explicit Windows(const EstimatorBankOptions& options)
      : intake(options.period_s, options.um_limit_v),
        swa{MakeSwa(EstimatorId::kSwa50),
            MakeSwa(EstimatorId::kSwa100),
            MakeSwa(EstimatorId::kSwa200)},
        sia{MakeSia(EstimatorId::kSia20x5, options),
            MakeSia(EstimatorId::kSia100x20, options),
            MakeSia(EstimatorId::kSia500x20, options)} {}

  template <typename Action>
  void ForEach(Action action) {
    for (Swa<1>& estimator : swa) {
      action(estimator);
    }
    for (Sia<1>& estimator : sia) {
      action(estimator);
    }
  }

  SampleIntake intake;
  std::array<Swa<1>, 3> swa;
  std::array<Sia<1>, 3> sia;
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
  const SampleStep step = windows_->intake.Take(sample);
  std::size_t at = 0;
  windows_->ForEach([&](auto& estimator) {
    Feed(step, sample, estimator);
    out[at++] = estimator.estimate();
  });
}

}  // namespace faultlab::core
