// Parity equations (paper section 1, [3, 10, 11, 26]): the residual of the known equation,
//   r(k) = y(k) - phi(k)' theta_0
// and its correlation with the equation's own columns over the newest W samples,
//   g = sum phi r,   statistic = g' (s^2 sum phi phi')^-1 g      (the constant left out)
// Isolation: a change of one component moves theta along a direction v, g = (sum phi phi') v eps;
// of a library of directions (seven changes a component, from 1/20 to 400 times) the one that
// leaves the least of g over is named. Only the direction is used, not the length. Identification:
// cannot. Tuning: W. Source: J. Gertler, Fault Detection and Diagnosis in Engineering Systems
// (1998), chapter 6; the local test: M. Basseville, Automatica 34 (1998).
#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/methods/hypotheses.h"
#include "core/methods/method_list.h"
#include "core/methods/regression.h"

namespace faultlab::core {
namespace {

class ParityEquations : public Method {
 public:
  explicit ParityEquations(const MethodTask& task)
      : task_(task), rows_(static_cast<std::size_t>(std::lround(task.tuning))) {
    NormalSums healthy;
    EquationRow row;
    for (const Observation& o : task.healthy) {
      if (NextRow(o, row)) healthy.Add(row);
    }
    theta_ = healthy.Solve();
    variance_ = std::max(healthy.ErrorVariance(theta_), 1e-12);
    CoefficientMap map(task_, std::make_unique<DiscreteEquation>());
    constexpr std::array kLogChanges = {-3.0, -1.0, -0.2, 0.2, 1.0, 3.0, 6.0};
    for (const Component component : task.bench->components()) {
      std::vector<Eigen::Vector3d> of_component;
      for (const double change : kLogChanges) {
        const EquationVector there = map.At(component, LogStart(task_, component) + change);
        of_component.push_back((there - map.healthy()).head<3>());
      }
      directions_.push_back(std::move(of_component));
    }
  }

  void Push(const Sample&, const Observation& o) override {
    EquationRow row;
    if (!NextRow(o, row)) return;
    row(kEquationParameters) -= row.head<kEquationParameters>().dot(theta_);
    if (held_ == rows_.size()) sum_ -= rows_[at_] * rows_[at_].transpose();
    rows_[at_] = row;
    sum_ += row * row.transpose();
    at_ = (at_ + 1) % rows_.size();
    held_ = std::min(held_ + 1, rows_.size());
    // The sums forget their rounding errors whenever the window begins anew.
    if (at_ == 0) {
      sum_.setZero();
      for (const EquationRow& each : rows_) sum_ += each * each.transpose();
    }
    if (held_ < rows_.size()) return;
    Reduce();
    statistic_ = g_.dot(information_.ldlt().solve(g_)) / variance_;
  }
  double statistic() const override { return statistic_; }
  MethodFinding Diagnose() override {
    MethodFinding finding;
    const Eigen::LDLT<Eigen::Matrix3d> solver(information_);
    const std::vector<Component> components = task_.bench->components();
    for (std::size_t c = 0; c < components.size(); ++c) {
      double most = 0.0;
      for (const Eigen::Vector3d& v : directions_[c]) {
        const double along = v.dot(information_ * v);
        const double share = std::max(0.0, v.dot(g_));
        if (along > 0.0) most = std::max(most, share * share / along);
      }
      const double left = g_.dot(solver.solve(g_)) - most;
      finding.candidates.push_back(
          {components[c], std::numeric_limits<double>::quiet_NaN(), left / variance_});
    }
    constexpr double kSame = 1e-3;
    FinishFinding(kSame, false, finding);
    return finding;
  }
  std::size_t bytes() const override {
    return sizeof *this + rows_.size() * sizeof(EquationRow) +
           directions_.size() * 7 * sizeof(Eigen::Vector3d);
  }

 private:
  bool NextRow(const Observation& o, EquationRow& row) {
    if (o.restart || !task_.Has(o)) equation_.Restart();
    return task_.Has(o) && equation_.Push(o.u, task_.Reading(o), row);
  }
  void Reduce() {
    const EquationMatrix all = sum_.topLeftCorner<kEquationParameters, kEquationParameters>();
    const EquationVector cross = sum_.topRightCorner<kEquationParameters, 1>();
    information_ = WithoutConstant(all);
    g_ = cross.head<3>() - all.topRightCorner<3, 1>() * (cross(3) / std::max(all(3, 3), 1e-300));
  }

  MethodTask task_;
  DiscreteEquation equation_;
  EquationVector theta_;
  double variance_ = 1.0;
  std::vector<std::vector<Eigen::Vector3d>> directions_;  ///< of a component: its changes
  std::vector<EquationRow> rows_;
  std::size_t at_ = 0;
  std::size_t held_ = 0;
  RowMoments sum_ = RowMoments::Zero();
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d g_ = Eigen::Vector3d::Zero();
  double statistic_ = 0.0;
};

}  // namespace

std::unique_ptr<Method> MakeParityEquations(const MethodTask& task) {
  return std::make_unique<ParityEquations>(task);
}

}  // namespace faultlab::core
