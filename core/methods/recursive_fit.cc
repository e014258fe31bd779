#include "core/methods/recursive_fit.h"

#include <Eigen/LU>
#include <algorithm>

namespace faultlab::core {
namespace {

EquationMatrix NothingKnown() {
  constexpr double kDoubt = 1e3;  // far above any coefficient's square
  return kDoubt * EquationMatrix::Identity();
}

}  // namespace

RecursiveFit::RecursiveFit(const MethodTask& task,
                           const std::function<std::unique_ptr<Equation>()>& equation,
                           const RecursiveFitOptions& options)
    : task_(task),
      equation_(equation()),
      map_(task_, equation()),
      rls_(map_.healthy(), NothingKnown(), options.lambda) {
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double count = 0.0;
  double errors = 0.0;
  for (std::size_t k = 0; k < task.healthy.size(); ++k) {
    const std::optional<double> error = Push(task.healthy[k]);
    if (!error || k < options.settle) continue;
    const Eigen::Vector3d off = Off();
    count += 1.0;
    mean_ += (off - mean_) / count;
    squares += off * off.transpose();
    errors += *error * *error;
  }
  error_variance_ = std::max(errors / std::max(count, 1.0), 1e-12);
  const Eigen::Matrix3d covariance = squares / std::max(count, 1.0) - mean_ * mean_.transpose();
  const Eigen::Matrix3d spread =
      covariance * (1.0 + options.memory / std::max(count, options.memory));
  healthy_information_ = spread.fullPivLu().solve(Eigen::Matrix3d::Identity());
}

std::optional<double> RecursiveFit::Push(const Observation& o) {
  EquationRow row;
  if (o.restart || !task_.Has(o)) equation_->Restart();
  if (!task_.Has(o) || !equation_->Push(o.u, task_.Reading(o), row)) return std::nullopt;
  return rls_.Push(row);
}

double RecursiveFit::Distance() const {
  const Eigen::Vector3d off = Off() - mean_;
  return off.dot(healthy_information_ * off);
}

void RecursiveFit::Doubt() {
  rls_.Reset(NothingKnown());
}

MethodFinding RecursiveFit::Match() {
  const EquationMatrix information =
      rls_.p().fullPivLu().solve(EquationMatrix::Identity()) / error_variance_;
  return map_.Match(rls_.theta(), WithoutConstant(information));
}

}  // namespace faultlab::core
