#include "core/diagnosis/paper_view.h"

#include <algorithm>
#include <cmath>

#include "core/plant/coefficients.h"

namespace faultlab::core {
namespace {

// The estimator whose estimate the paper's methods are applied to.
constexpr std::size_t kEstimatorForPath = static_cast<std::size_t>(EstimatorId::kSia100x20);

}  // namespace

PaperMethods PaperMethodsAt(const Bench& bench,
                            const Frame& frame,
                            const Calibration& calibration) {
  const Estimate<3>& sia = frame.estimates[kEstimatorForPath];
  if (sia.status == EstimateStatus::kInvalid) return {};
  const ContinuousTheta nominal = FirstOrderTheta(calibration.nominal, calibration.gain_factor);
  // Four standard errors, but at least the error of the reduction to first order (1 %).
  ContinuousTheta band{};
  for (std::size_t i = 0; i < band.size(); ++i) {
    const double sigma = std::isfinite(sia.sigma[i]) ? sia.sigma[i] : 0.0;
    band[i] = std::max(4.0 * sigma, 0.02 * std::abs(nominal[i]));
  }
  return RunPaperMethods(
      bench, calibration.nominal, nominal, {sia.theta[0], sia.theta[1], sia.theta[2]}, band);
}

std::array<ContinuousTheta, kEstimatorCount> NominalEstimates(const DiagnosisOptions& options,
                                                              const Calibration* calibration) {
  const PlantParameters plant = calibration != nullptr ? calibration->nominal : options.nominal;
  const double gain_factor = calibration != nullptr ? calibration->gain_factor : 1.0;
  const double delta_s = calibration != nullptr ? calibration->delta_s : 0.0;
  const ContinuousTheta theta = FirstOrderTheta(plant, gain_factor);
  ContinuousCoefficients coefficients = MakeContinuous(plant);
  coefficients.b0 = theta[0];
  coefficients.b1 = theta[1];
  const DiscreteCoefficients discrete = Discretise(coefficients, options.period_s, delta_s);
  std::array<ContinuousTheta, kEstimatorCount> nominal{};
  for (std::size_t e = 0; e < kEstimatorCount; ++e) {
    nominal[e] = kEstimatorShapes[e].integral_samples > 0
                     ? theta
                     : ContinuousTheta{discrete.b0d, discrete.b1d, discrete.a1d};
  }
  return nominal;
}

}  // namespace faultlab::core
