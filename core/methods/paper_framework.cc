// The paper's own two methods, as it describes them; core/estimators and core/paper have the parts.
//   SWA + selected Jacobian    theta = {b0d, b1d, a1d}, converted to (b0, b1, a1); the component
//                              whose single column explains the change best, value by
//                              Eq. (42), (43)
//   SIA + decision algorithm   theta = {b0, b1, a1}; the component at the end of the path of
//                              Fig. 21, value by Eq. (4), (7) solved for it
// Both with the output's noise subtracted, and SIA with the rule of its integrals inverted.
// Detection: the largest distance of a coefficient from its healthy mean, in standard deviations.
// Tuning: K of the window: 50, 100, 200 of SWA; 20, 100, 500 of SIA.
// Source: paper sections 3.1-3.2, Eq. (4)-(31), (36)-(43), Fig. 21.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/methods/estimate_bands.h"
#include "core/methods/method_list.h"
#include "core/paper/paper_methods.h"
#include "core/plant/coefficients.h"

namespace faultlab::core {
namespace {

enum class PaperEstimator { kSwa, kSia };

class PaperFramework : public Method {
 public:
  PaperFramework(const MethodTask& task, PaperEstimator form)
      : task_(task),
        form_(form),
        bands_(task_,
               FirstOrderSpec(task_,
                              task.tuning,
                              form == PaperEstimator::kSia ? PaperIntegral(task.tuning) : 0,
                              false)) {}

  void Push(const Sample& sample, const Observation&) override { bands_.Push(sample); }
  double statistic() const override { return bands_.Distance(); }
  MethodFinding Diagnose() override {
    MethodFinding finding{Answer::kNotYet, Answer::kNotYet, {}, 0};
    if (!bands_.usable()) return finding;
    const Calibration& known = task_.calibration;
    const ContinuousTheta nominal = FirstOrderTheta(known.nominal, known.gain_factor);
    ContinuousTheta estimate{};
    ContinuousTheta band{};
    if (form_ == PaperEstimator::kSwa) {
      const std::optional<ContinuousCoefficients> found = Continuous(bands_.theta());
      const std::optional<ContinuousCoefficients> healthy = Continuous(bands_.mean());
      if (!found || !healthy) return finding;
      // What the conversion makes of the healthy mean is its own zero.
      estimate = {nominal[0] + found->b0 - healthy->b0,
                  nominal[1] + found->b1 - healthy->b1,
                  nominal[2] + found->a1 - healthy->a1};
      for (std::size_t i = 0; i < band.size(); ++i) band[i] = kLeastBand * std::abs(nominal[i]);
    } else {
      for (std::size_t i = 0; i < band.size(); ++i) {
        estimate[i] = nominal[i] + bands_.theta()[i] - bands_.mean()[i];
        band[i] = std::max(kBand * bands_.sd()[i], kLeastBand * std::abs(nominal[i]));
      }
    }
    const PaperMethods all = RunPaperMethods(*task_.bench, known.nominal, nominal, estimate, band);
    const bool solved = form_ == PaperEstimator::kSia;
    for (const InverseSolution& solution : solved ? all.exact : all.single_column) {
      const bool named =
          std::find(all.named.begin(), all.named.end(), solution.component) != all.named.end();
      const double value =
          solution.exists ? solution.value : std::numeric_limits<double>::quiet_NaN();
      const double cost = solved            ? (named ? 0.0 : 1.0)
                          : solution.exists ? solution.mismatch
                                            : 1.0 + solution.mismatch;
      finding.candidates.push_back({solution.component, value, cost});
    }
    if (form_ == PaperEstimator::kSia && all.named.empty()) {
      finding.candidates.clear();
      if (all.path.empty()) return {Answer::kCannot, Answer::kCannot, {}, 0};
    }
    constexpr double kSame = 1e-6;
    FinishFinding(kSame, true, finding);
    return finding;
  }
  std::size_t bytes() const override {
    constexpr double kRow = 4.0;
    const double integral = form_ == PaperEstimator::kSia ? PaperIntegral(task_.tuning) : 0.0;
    return static_cast<std::size_t>((task_.tuning + integral) * kRow) * sizeof(double);
  }

 private:
  static constexpr double kBand = 4.0;
  static constexpr double kLeastBand = 0.02;

  std::optional<ContinuousCoefficients> Continuous(const EstimateBands::Values& d) const {
    return MakeContinuous(
        DiscreteCoefficients{d[0], d[1], d[2]}, task_.period_s, task_.calibration.delta_s);
  }

  MethodTask task_;
  PaperEstimator form_;
  EstimateBands bands_;
};

}  // namespace

std::unique_ptr<Method> MakePaperSwa(const MethodTask& task) {
  return std::make_unique<PaperFramework>(task, PaperEstimator::kSwa);
}
std::unique_ptr<Method> MakePaperSia(const MethodTask& task) {
  return std::make_unique<PaperFramework>(task, PaperEstimator::kSia);
}

}  // namespace faultlab::core
