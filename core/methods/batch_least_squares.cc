// Least squares of a batch (paper section 1, [18, 32, 38]): the equation y = phi' theta is solved
// once for each block of N samples,
//   theta = (sum phi phi')^-1 sum phi y,     cov theta = s^2 (sum phi phi')^-1
// Detection:  d' (cov theta + cov theta_0)^-1 d,  d = theta - theta_0 without the constant, theta_0
//             of the healthy stretch; it changes only at the end of a block.
// Isolation, identification: all rows since the alarm in one batch, CoefficientMap.
// Tuning: N.
// Source: L. Ljung, System Identification, 2nd ed. (1999), section 7.3; paper Eq. (10)-(14).
#include <Eigen/Cholesky>

#include "core/methods/method_list.h"
#include "core/methods/regression.h"

namespace faultlab::core {
namespace {

class BatchLeastSquares : public Method {
 public:
  explicit BatchLeastSquares(const MethodTask& task)
      : task_(task), map_(task_, std::make_unique<DiscreteEquation>()), block_(task.tuning) {
    NormalSums healthy;
    EquationRow row;
    for (const Observation& o : task.healthy) {
      if (NextRow(o, row)) healthy.Add(row);
    }
    healthy_ = healthy.Solve();
    healthy_information_ = Information(healthy, healthy_);
  }

  void Push(const Sample&, const Observation& o) override {
    EquationRow row;
    if (!NextRow(o, row)) return;
    sums_.Add(row);
    if (alarmed_ || sums_.rows < block_) return;
    const EquationVector theta = sums_.Solve();
    const Eigen::Vector3d off = (theta - healthy_).head<3>();
    const Eigen::Matrix3d own = Information(sums_, theta);
    // Two covariances: (I1^-1 + I2^-1)^-1 = I1 (I1 + I2)^-1 I2.
    const Eigen::Matrix3d both = own + healthy_information_;
    const Eigen::Vector3d weighed = own * both.ldlt().solve(healthy_information_ * off);
    statistic_ = off.dot(weighed);
    sums_ = {};
  }
  double statistic() const override { return statistic_; }
  void OnAlarm() override {
    alarmed_ = true;
    sums_ = {};
  }
  MethodFinding Diagnose() override {
    if (sums_.rows < kRowsMin) return {Answer::kNotYet, Answer::kNotYet, {}, 0};
    const EquationVector theta = sums_.Solve();
    return map_.Match(theta, Information(sums_, theta));
  }
  std::size_t bytes() const override { return sizeof *this; }

 private:
  static constexpr double kRowsMin = 10.0;

  bool NextRow(const Observation& o, EquationRow& row) {
    if (o.restart || !task_.Has(o)) equation_.Restart();
    return task_.Has(o) && equation_.Push(o.u, task_.Reading(o), row);
  }
  static Eigen::Matrix3d Information(const NormalSums& sums, const EquationVector& theta) {
    return WithoutConstant(sums.information()) / std::max(sums.ErrorVariance(theta), 1e-12);
  }

  MethodTask task_;
  DiscreteEquation equation_;
  CoefficientMap map_;
  double block_;
  NormalSums sums_;
  EquationVector healthy_;
  Eigen::Matrix3d healthy_information_;
  double statistic_ = 0.0;
  bool alarmed_ = false;
};

}  // namespace

std::unique_ptr<Method> MakeBatchLeastSquares(const MethodTask& task) {
  return std::make_unique<BatchLeastSquares>(task);
}

}  // namespace faultlab::core
