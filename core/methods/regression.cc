#include "core/methods/regression.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/isolation/profile_cost.h"
#include "core/methods/hypotheses.h"

namespace faultlab::core {

bool DiscreteEquation::Push(double u, double y, EquationRow& row) {
  row << u, u_, -y_, 1.0, y;
  u_ = u;
  y_ = y;
  const bool whole = started_;
  started_ = true;
  return whole;
}

RowMoments DiscreteEquation::NoiseMoments() const {
  RowMoments moments = RowMoments::Zero();
  moments(2, 2) = 1.0;  // y(k-1)
  moments(4, 4) = 1.0;  // y(k)
  return moments;
}

EquationVector NormalSums::Solve() const {
  return information().ldlt().solve(sum.topRightCorner<kEquationParameters, 1>());
}

double NormalSums::ErrorVariance(const EquationVector& theta) const {
  EquationRow error;
  error << -theta, 1.0;
  const double freedom = std::max(1.0, rows - kEquationParameters);
  return std::max(0.0, error.dot(sum * error)) / freedom;
}

Eigen::Matrix3d WithoutConstant(const EquationMatrix& information) {
  const Eigen::Vector3d shared = information.topRightCorner<3, 1>();
  const Eigen::Matrix3d reduced = information.topLeftCorner<3, 3>() -
                                  shared * shared.transpose() / std::max(information(3, 3), 1e-300);
  return reduced;
}

namespace {
// Inputs that a fit of the map uses: more change its coefficients by less than noise does.
constexpr std::size_t kMapSamples = 450;
}  // namespace

CoefficientMap::CoefficientMap(const MethodTask& task, std::unique_ptr<Equation> equation)
    : task_(task), equation_(std::move(equation)) {
  for (const Observation& o : task.healthy) {
    if (u_.size() == kMapSamples) break;
    u_.push_back(o.u);
  }
  healthy_ = Fit(HealthyModel(task));
}

EquationVector CoefficientMap::Fit(const PredictionModel& model) {
  equation_->Restart();
  NormalSums sums;
  if (u_.empty()) return EquationVector::Zero();
  double mean = 0.0;
  for (const double u : u_) mean += u / static_cast<double>(u_.size());
  Eigen::Vector4d x = TurningState(model, mean);
  const int row = task_.channel();
  double before = u_.front();
  EquationRow next;
  for (const double u : u_) {
    const Eigen::Vector4d moved = Step(model, x, model.Limited(before), model.Limited(u));
    x = moved;
    const double y = model.c.row(row).dot(x) + model.d(row) * model.Limited(u);
    before = u;
    if (equation_->Push(u, y, next)) sums.Add(next);
  }
  sums.sum += equation_->NoiseMoments() * (sums.rows * task_.noise() * task_.noise());
  return sums.Solve();
}

EquationVector CoefficientMap::At(Component component, double log_value) {
  return Fit(ModelOf(task_, component, log_value));
}

MethodFinding CoefficientMap::Match(const EquationVector& theta,
                                    const Eigen::Matrix3d& information) {
  const std::vector<Component> components = task_.bench->components();
  if (scans_.empty()) {
    for (const Component component : components) {
      std::vector<EquationVector> scan;
      const ValueRange range = RangeOf(component);
      for (int i = 0; i < range.points; ++i) scan.push_back(At(component, range.LogAt(i)));
      scans_.push_back(std::move(scan));
    }
  }
  const auto distance = [&](const EquationVector& at) {
    const Eigen::Vector3d off = (theta - at).head<3>();
    return off.dot(information * off);
  };
  MethodFinding finding;
  for (std::size_t c = 0; c < components.size(); ++c) {
    std::vector<double> costs;
    for (const EquationVector& at : scans_[c]) costs.push_back(distance(at));
    finding.candidates.push_back(
        SearchValue(components[c], costs, [&](Component component, double log_value) {
          return distance(At(component, log_value));
        }));
  }
  constexpr double kSame = 1e-3;  // of a squared number of standard errors: rounding
  FinishFinding(kSame, true, finding);
  return finding;
}

}  // namespace faultlab::core
