#include "core/diagnosis/map_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

// Forward differences: the innovations are smooth in the coordinates, their rounding is 1e-12.
constexpr double kDifference = 1e-5;

double PriorCost(const GaussianPrior& prior, const Eigen::VectorXd& q) {
  const Eigen::VectorXd off = q - prior.mean;
  return off.dot(prior.information * off);
}

// Runs the models of several points side by side.
class PointRuns {
 public:
  explicit PointRuns(const StretchModels& models) : models_(models) {}

  /// One column of `points`, one of `table`, one of sums() each.
  void Run(const Eigen::MatrixXd& points, InnovationTable& table) {
    const auto count = static_cast<std::size_t>(points.cols());
    const std::size_t length = models_.from.size();
    made_.resize(count * length);
    segments_.resize(count * length);
    paths_.resize(count);
    sums_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      point_ = points.col(static_cast<Eigen::Index>(i));
      for (std::size_t s = 0; s < length; ++s) {
        const std::size_t at = i * length + s;
        made_[at] = models_.model_at(point_, s);
        segments_[at] = {models_.from[s], &made_[at]};
      }
      paths_[i] = ModelPath(segments_).subspan(i * length, length);
    }
    RunInnovations(paths_, models_.stretch, sums_, &table);
  }

  const std::vector<InnovationSummary>& sums() const { return sums_; }

 private:
  const StretchModels& models_;
  Eigen::VectorXd point_;
  std::vector<PredictionModel> made_;
  std::vector<ModelSegment> segments_;
  std::vector<ModelPath> paths_;
  std::vector<InnovationSummary> sums_;
};

}  // namespace

MapFit FitMap(const StretchModels& models,
              const GaussianPrior& prior,
              const Eigen::VectorXd& start,
              const MapFitOptions& options) {
  const Eigen::Index n = start.size();
  LAB_CHECK(prior.mean.size() == n && prior.information.rows() == n, n);
  MapFit fit;
  fit.point = start;
  PointRuns runs(models);
  InnovationTable base;
  InnovationTable tried;
  InnovationTable moved;
  runs.Run(fit.point, base);
  fit.innovations = runs.sums().front();
  fit.prior_cost = PriorCost(prior, fit.point);
  double damping = 0.0;
  InnovationTable jacobian;
  for (; fit.iterations < options.iterations_max; ++fit.iterations) {
    Eigen::MatrixXd points = fit.point.replicate(1, n);
    points.diagonal().array() += kDifference;
    runs.Run(points, moved);
    const Eigen::VectorXd z = base.col(0);
    jacobian = (moved.leftCols(n).colwise() - z) / kDifference;
    fit.information.noalias() = jacobian.transpose() * jacobian;
    const Eigen::VectorXd gradient =
        jacobian.transpose() * z + prior.information * (fit.point - prior.mean);
    const Eigen::MatrixXd curvature = fit.information + prior.information;
    bool accepted = false;
    double step_in_sigma = 0.0;
    for (int attempt = 0; attempt < 6 && !accepted; ++attempt) {
      Eigen::MatrixXd damped = curvature;
      damped.diagonal() += damping * curvature.diagonal();
      damped.diagonal().array() += 1e-9 * (1.0 + curvature.diagonal().maxCoeff() * 1e-9);
      Eigen::VectorXd step = damped.ldlt().solve(-gradient);
      const double longest = step.cwiseAbs().maxCoeff();
      if (!(longest < 1e6)) break;
      if (longest > options.step_max) step *= options.step_max / longest;
      step_in_sigma = std::sqrt(std::max(0.0, step.dot(curvature * step)));
      const Eigen::VectorXd q = fit.point + step;
      runs.Run(q, tried);
      const InnovationSummary& sum = runs.sums().front();
      const double tried_prior = PriorCost(prior, q);
      if (sum.cost() + tried_prior <= fit.cost() + 1e-6) {
        fit.point = q;
        fit.innovations = sum;
        fit.prior_cost = tried_prior;
        base.swap(tried);
        accepted = true;
        damping = damping > 1e-3 ? damping * 0.1 : 0.0;
      } else {
        damping = damping > 0.0 ? damping * 10.0 : 1e-2;
      }
    }
    if (!accepted || step_in_sigma < options.step_tolerance) {
      fit.converged = accepted || step_in_sigma < 1.0;
      break;
    }
  }
  Eigen::MatrixXd curvature = fit.information + prior.information;
  curvature.diagonal().array() += 1e-9;
  fit.covariance = curvature.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  return fit;
}

}  // namespace faultlab::core
