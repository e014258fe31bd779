// Recursive least squares with forgetting (paper section 1, [30, 31]); the recursion is in
// recursive_least_squares.h. Two forms:
//   forgetting   Detection: d' S^-1 d, d the distance of (b0d, b1d, a1d) from its mean over the
//                healthy stretch, S its covariance there plus that of the mean.
//   reset        Detection: variance of the newest 8 prediction errors over that of the healthy
//                stretch; at the alarm P is replaced by P0, so that the old plant is forgotten at
//                once.
// Isolation, identification: CoefficientMap, information P^-1 / s^2.
// Tuning: lambda.
// Source: L. Ljung, System Identification, 2nd ed. (1999), section 11.2; reset by a test of the
// error's variance: F. Gustafsson, Adaptive Filtering and Change Detection (2000), chapter 5.
#include <array>
#include <memory>
#include <numeric>
#include <optional>

#include "core/methods/method_list.h"
#include "core/methods/recursive_fit.h"

namespace faultlab::core {
namespace {

enum class Memory { kForgetting, kReset };

class ForgettingLeastSquares : public Method {
 public:
  ForgettingLeastSquares(const MethodTask& task, Memory form)
      : task_(task),
        form_(form),
        fit_(task_,
             [] { return std::make_unique<DiscreteEquation>(); },
             {.lambda = task.tuning,
              .settle = task.healthy.size() / 4,
              .memory = 2.0 / (1.0 - task.tuning)}) {}

  void Push(const Sample&, const Observation& o) override {
    const std::optional<double> error = fit_.Push(o);
    if (!error) return;
    if (form_ == Memory::kForgetting) {
      statistic_ = fit_.Distance();
      return;
    }
    squares_[at_] = *error * *error / fit_.error_variance();
    at_ = (at_ + 1) % squares_.size();
    statistic_ = std::accumulate(squares_.begin(), squares_.end(), 0.0);
  }
  double statistic() const override { return statistic_; }
  void OnAlarm() override {
    if (form_ == Memory::kReset) fit_.Doubt();
  }
  MethodFinding Diagnose() override { return fit_.Match(); }
  std::size_t bytes() const override { return sizeof *this + fit_.bytes(); }

 private:
  MethodTask task_;
  Memory form_;
  RecursiveFit fit_;
  std::array<double, 8> squares_{};
  std::size_t at_ = 0;
  double statistic_ = 0.0;
};

}  // namespace

std::unique_ptr<Method> MakeForgettingLeastSquares(const MethodTask& task) {
  return std::make_unique<ForgettingLeastSquares>(task, Memory::kForgetting);
}
std::unique_ptr<Method> MakeResettingLeastSquares(const MethodTask& task) {
  return std::make_unique<ForgettingLeastSquares>(task, Memory::kReset);
}

}  // namespace faultlab::core
