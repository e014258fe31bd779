// Algebraic derivative estimation (paper section 1, AGT [33]): over a window of M samples the
// derivative of the best straight line through y, and its mean,
//   y' = 12 / (M (M^2 - 1) T) sum (j - (M-1)/2) y(k-M+1+j),     ybar = 1/M sum y
// turn the differential equation of first order into one that is linear in its coefficients,
//   ybar = b0 ubar + b1 u' - a1 y' + c
// which least squares with forgetting solves. Read off directly the coefficients are biased: the
// derivative of a held input is a row of impulses. CoefficientMap carries the same bias.
// Detection: d' S^-1 d of (b0, b1, a1), as recursive least squares. Tuning: M.
// Source: M. Mboup, C. Join, M. Fliess, Numerical Algorithms 50 (2009), 439-467: the first order
// algebraic estimator is the slope of the least-squares line.
#include <cmath>
#include <limits>
#include <vector>

#include "core/methods/method_list.h"
#include "core/methods/recursive_fit.h"

namespace faultlab::core {
namespace {

class DerivativeEquation : public Equation {
 public:
  DerivativeEquation(std::size_t window, double period_s)
      : u_(window, 0.0), y_(window, 0.0), slope_(window) {
    const double m = static_cast<double>(window);
    const double scale = 12.0 / (m * (m * m - 1.0) * period_s);
    for (std::size_t j = 0; j < window; ++j) {
      slope_[j] = scale * (static_cast<double>(j) - 0.5 * (m - 1.0));
    }
  }

  bool Push(double u, double y, EquationRow& row) override {
    u_[at_] = u;
    y_[at_] = y;
    at_ = (at_ + 1) % u_.size();
    held_ = std::min(held_ + 1, u_.size());
    if (held_ < u_.size()) return false;
    double ubar = 0.0;
    double ybar = 0.0;
    double du = 0.0;
    double dy = 0.0;
    for (std::size_t j = 0; j < u_.size(); ++j) {
      const std::size_t k = (at_ + j) % u_.size();
      ubar += u_[k];
      ybar += y_[k];
      du += slope_[j] * u_[k];
      dy += slope_[j] * y_[k];
    }
    const double m = static_cast<double>(u_.size());
    row << ubar / m, du, -dy, 1.0, ybar / m;
    return true;
  }
  void Restart() override { held_ = 0; }
  RowMoments NoiseMoments() const override {
    RowMoments moments = RowMoments::Zero();
    for (const double slope : slope_) moments(2, 2) += slope * slope;
    moments(4, 4) = 1.0 / static_cast<double>(u_.size());
    return moments;  // the mean and the slope of white noise are uncorrelated
  }
  std::size_t bytes() const override { return sizeof *this + 3 * u_.size() * sizeof(double); }

 private:
  std::vector<double> u_;
  std::vector<double> y_;
  std::vector<double> slope_;
  std::size_t at_ = 0;
  std::size_t held_ = 0;
};

class AlgebraicDerivatives : public Method {
 public:
  explicit AlgebraicDerivatives(const MethodTask& task)
      : task_(task),
        fit_(task_,
             [this] {
               const auto window = static_cast<std::size_t>(std::lround(task_.tuning));
               return std::make_unique<DerivativeEquation>(window, task_.period_s);
             },
             {.lambda = 0.99, .settle = task.healthy.size() / 3, .memory = kAllOfIt}) {}

  void Push(const Sample&, const Observation& o) override {
    if (fit_.Push(o)) statistic_ = fit_.Distance();
  }
  double statistic() const override { return statistic_; }
  void OnAlarm() override { fit_.Doubt(); }
  MethodFinding Diagnose() override { return fit_.Match(); }
  std::size_t bytes() const override { return sizeof *this + fit_.bytes(); }

 private:
  static constexpr double kAllOfIt = std::numeric_limits<double>::max();

  MethodTask task_;
  RecursiveFit fit_;
  double statistic_ = 0.0;
};

}  // namespace

std::unique_ptr<Method> MakeAlgebraicDerivatives(const MethodTask& task) {
  return std::make_unique<AlgebraicDerivatives>(task);
}

}  // namespace faultlab::core
