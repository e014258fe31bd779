#include "core/methods/parameter_filter.h"

#include <algorithm>
#include <cmath>

#include "core/isolation/fit_context.h"
#include "core/isolation/profile_cost.h"

namespace faultlab::core {

PredictionModel ModelOf(const MethodTask& task,
                        const std::vector<Component>& components,
                        const Eigen::Ref<const Eigen::VectorXd>& log_values) {
  RigParameters rig = ParametersOf(task.calibration);
  for (std::size_t i = 0; i < components.size(); ++i) {
    rig = WithComponent(rig, components[i], std::exp(log_values(static_cast<Eigen::Index>(i))));
  }
  return MakePredictionModel(rig, NoiseOf(task.calibration), task.period_s);
}

ParameterFilter::ParameterFilter(const MethodTask& task, const ParameterFilterSetup& setup)
    : task_(task), components_(setup.components), walk_(setup.walk) {
  const auto p = static_cast<Eigen::Index>(components_.size());
  x_.resize(4 + p);
  x_ << setup.x, setup.log_values;
  p_ = Eigen::MatrixXd::Zero(4 + p, 4 + p);
  p_.topLeftCorner<4, 4>() = setup.p;
  p_.bottomRightCorner(p, p).diagonal().setConstant(setup.log_sd * setup.log_sd);
  for (const Component component : components_) {
    const ValueRange range = RangeOf(component);
    log_low_.push_back(std::log(range.low));
    log_high_.push_back(std::log(range.high));
  }
}

PredictionModel ParameterFilter::At(const Eigen::Ref<const Eigen::VectorXd>& augmented) const {
  // A point outside a range acts as its end.
  Eigen::VectorXd inside = augmented.tail(augmented.size() - 4);
  for (std::size_t i = 0; i < components_.size(); ++i) {
    double& log_value = inside(static_cast<Eigen::Index>(i));
    log_value = std::clamp(log_value, log_low_[i], log_high_[i]);
  }
  return ModelOf(task_, components_, inside);
}

void ParameterFilter::Push(const Observation& o) {
  Predict(o);
  p_.bottomRightCorner(x_.size() - 4, x_.size() - 4).diagonal().array() += walk_ * walk_;
  if (task_.Has(o)) Correct(o);
  Clamp();
  const Eigen::MatrixXd symmetric = 0.5 * (p_ + p_.transpose());
  p_ = symmetric;
}

void ParameterFilter::Clamp() {
  for (std::size_t i = 0; i < components_.size(); ++i) {
    double& log_value = x_(4 + static_cast<Eigen::Index>(i));
    log_value = std::clamp(log_value, log_low_[i], log_high_[i]);
  }
}

void ParameterFilter::Doubt(double log_sd) {
  p_.bottomRightCorner(x_.size() - 4, x_.size() - 4).diagonal().array() += log_sd * log_sd;
}

std::size_t ParameterFilter::bytes() const {
  return sizeof *this + static_cast<std::size_t>(x_.size() + p_.size()) * sizeof(double) +
         components_.size() * sizeof(Component);
}

}  // namespace faultlab::core
