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
#include <Eigen/LU>
#include <array>
#include <cmath>

#include "core/methods/method_list.h"
#include "core/methods/recursive_least_squares.h"
#include "core/methods/regression.h"

namespace faultlab::core {
namespace {

enum class Form { kForgetting, kReset };

class ForgettingLeastSquares : public Method {
 public:
  ForgettingLeastSquares(const MethodTask& task, Form form)
      : task_(task),
        form_(form),
        map_(task_, std::make_unique<DiscreteEquation>()),
        rls_(map_.healthy(), Doubt(), task.tuning) {
    // The first part of the stretch settles the recursion, the rest measures it.
    const std::size_t settle = task.healthy.size() / 4;
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    double count = 0.0;
    double errors = 0.0;
    for (std::size_t k = 0; k < task.healthy.size(); ++k) {
      double error = 0.0;
      if (!Update(task.healthy[k], error) || k < settle) continue;
      const Eigen::Vector3d off = (rls_.theta() - map_.healthy()).head<3>();
      count += 1.0;
      mean_ += (off - mean_) / count;
      squares += off * off.transpose();
      errors += error * error;
    }
    error_variance_ = std::max(errors / std::max(count, 1.0), 1e-12);
    const double memory = 2.0 / (1.0 - task.tuning);
    const Eigen::Matrix3d covariance = squares / std::max(count, 1.0) - mean_ * mean_.transpose();
    const Eigen::Matrix3d spread = covariance * (1.0 + memory / std::max(count, memory));
    Eigen::FullPivLU<Eigen::Matrix3d> lu(spread);
    healthy_information_ = lu.solve(Eigen::Matrix3d::Identity());
  }

  void Push(const Sample&, const Observation& o) override {
    double error = 0.0;
    if (!Update(o, error)) return;
    if (form_ == Form::kForgetting) {
      const Eigen::Vector3d off = (rls_.theta() - map_.healthy()).head<3>() - mean_;
      statistic_ = off.dot(healthy_information_ * off);
      return;
    }
    squares_[at_] = error * error / error_variance_;
    at_ = (at_ + 1) % squares_.size();
    double sum = 0.0;
    for (const double square : squares_) sum += square;
    statistic_ = sum;
  }
  double statistic() const override { return statistic_; }
  void OnAlarm() override {
    if (form_ == Form::kReset) rls_.Reset(Doubt());
  }
  MethodFinding Diagnose() override {
    const EquationMatrix information =
        rls_.p().fullPivLu().solve(EquationMatrix::Identity()) / error_variance_;
    return map_.Match(rls_.theta(), WithoutConstant(information));
  }
  std::size_t bytes() const override { return sizeof *this; }

 private:
  static EquationMatrix Doubt() {
    constexpr double kDoubt = 1e3;  // far above any coefficient's square
    return kDoubt * EquationMatrix::Identity();
  }
  bool Update(const Observation& o, double& error) {
    EquationRow row;
    if (o.restart || !task_.Has(o)) equation_.Restart();
    if (!task_.Has(o) || !equation_.Push(o.u, task_.Reading(o), row)) return false;
    error = rls_.Push(row);
    return true;
  }

  MethodTask task_;
  Form form_;
  DiscreteEquation equation_;
  CoefficientMap map_;
  RecursiveLeastSquares rls_;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d healthy_information_ = Eigen::Matrix3d::Identity();
  double error_variance_ = 1.0;
  std::array<double, 8> squares_{};
  std::size_t at_ = 0;
  double statistic_ = 0.0;
};

}  // namespace

std::unique_ptr<Method> MakeForgettingLeastSquares(const MethodTask& task) {
  return std::make_unique<ForgettingLeastSquares>(task, Form::kForgetting);
}
std::unique_ptr<Method> MakeResettingLeastSquares(const MethodTask& task) {
  return std::make_unique<ForgettingLeastSquares>(task, Form::kReset);
}

}  // namespace faultlab::core
