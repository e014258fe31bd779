#include "core/filter/map_fit.h"

#include <algorithm>
#include <cmath>

#include "core/filter/simd/lane_products.h"
#include "core/numerics/linear_systems.h"
#include "core/types/check.h"

namespace faultlab::core {
namespace {

// Step of the forward differences: the innovations are smooth in the coordinates, their rounding
// error is 1e-12.
constexpr double kDifference = 1e-5;

// A fit is given up when even this many times the predicted gain of a full Gauss-Newton step would
// not bring it below the limit. Of a thousand fits of isolation_bench three needed more; all three
// had a cost a hundred times above the noise.
constexpr double kReach = 4.0;

double PriorCost(const GaussianPrior& prior, const Eigen::VectorXd& q) {
  const Eigen::VectorXd off = q - prior.mean;
  return off.dot(prior.information * off);
}

// A point, and how the innovations change around it.
struct Linearisation {
  InnovationSummary sum;
  Eigen::MatrixXd information;  ///< J'J
  Eigen::VectorXd slope;        ///< J'z
};

// Runs the models that belong to points.
class PointRuns {
 public:
  PointRuns(const StretchModels& models, bool follow_noise)
      : models_(models), follow_noise_(follow_noise) {}

  InnovationSummary At(const Eigen::VectorXd& point) {
    Run(point, nullptr);
    return sums_.front();
  }

  /// Runs the point and all its neighbours, side by side.
  Linearisation Around(const Eigen::VectorXd& point) {
    const Eigen::Index n = point.size();
    Eigen::MatrixXd points = point.replicate(1, n + 1);
    points.diagonal().array() += kDifference;
    Run(points, &table_);
    LAB_CHECK(table_.cols() <= static_cast<Eigen::Index>(kProductColumnsMax), n);
    ProductSums sums;
    SumProducts({table_.data(),
                 static_cast<std::size_t>(table_.rows()),
                 static_cast<std::size_t>(table_.cols()),
                 static_cast<std::size_t>(n),
                 1.0 / kDifference},
                sums);
    const Eigen::Map<const Eigen::Matrix<double, kProductColumnsMax, kProductColumnsMax>> lower(
        sums.front().data());
    Linearisation around;
    around.sum = sums_[static_cast<std::size_t>(n)];
    around.information = lower.topLeftCorner(n, n).selfadjointView<Eigen::Lower>();
    around.slope = lower.row(n).head(n).transpose();
    for (Eigen::Index i = 0; follow_noise_ && i < n; ++i) {
      const double change = sums_[static_cast<std::size_t>(i)].log_det - around.sum.log_det;
      around.slope(i) += 0.5 * change / kDifference;
    }
    return around;
  }

 private:
  void Run(const Eigen::MatrixXd& points, InnovationTable* table) {
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
    RunInnovations(paths_, models_.stretch, sums_, table);
  }

  const StretchModels& models_;
  bool follow_noise_;
  Eigen::VectorXd point_;
  std::vector<PredictionModel> made_;
  std::vector<ModelSegment> segments_;
  std::vector<ModelPath> paths_;
  std::vector<InnovationSummary> sums_;
  InnovationTable table_;
};

}  // namespace

MapFit FitMap(const StretchModels& models,
              const GaussianPrior& prior,
              const Eigen::VectorXd& start,
              const MapFitOptions& options) {
  const Eigen::Index n = start.size();
  LAB_CHECK(prior.mean.size() == n && prior.information.rows() == n, n);
  PointRuns runs(models, options.follow_noise);
  MapFit fit;
  fit.point = start;
  fit.prior_cost = PriorCost(prior, start);
  Linearisation here = runs.Around(start);
  Linearisation there;
  fit.innovations = here.sum;
  bool here_is_the_point = true;
  double damping = 0.0;
  for (; fit.iterations < options.iterations_max; ++fit.iterations) {
    if (!here_is_the_point) here = runs.Around(fit.point);
    here_is_the_point = true;
    const Eigen::VectorXd gradient = here.slope + prior.information * (fit.point - prior.mean);
    const Eigen::MatrixXd curvature = here.information + prior.information;
    bool accepted = false;
    bool given_up = false;
    double step_in_sigma = 0.0;
    for (int attempt = 0; attempt < 6 && !accepted; ++attempt) {
      Eigen::MatrixXd damped = curvature;
      damped.diagonal() += damping * curvature.diagonal();
      damped.diagonal().array() += 1e-9 * (1.0 + curvature.diagonal().maxCoeff() * 1e-9);
      Eigen::VectorXd step = -SolveSymmetric(damped, gradient);
      const double longest = step.cwiseAbs().maxCoeff();
      if (!(longest < 1e6)) break;
      given_up = attempt == 0 && fit.cost() + kReach * gradient.dot(step) > options.give_up_above;
      if (given_up) break;
      if (longest > options.step_max) step *= options.step_max / longest;
      step_in_sigma = std::sqrt(std::max(0.0, step.dot(curvature * step)));
      const Eigen::VectorXd q = fit.point + step;
      // If another step follows this one, the neighbours of its point are needed too.
      const bool goes_on = damping == 0.0 && step_in_sigma >= options.step_tolerance &&
                           fit.iterations + 1 < options.iterations_max;
      if (goes_on) there = runs.Around(q);
      const InnovationSummary sum = goes_on ? there.sum : runs.At(q);
      const double tried_prior = PriorCost(prior, q);
      if (sum.cost() + tried_prior <= fit.cost() + 1e-6) {
        fit.point = q;
        fit.innovations = sum;
        fit.prior_cost = tried_prior;
        if (goes_on) std::swap(here, there);
        here_is_the_point = goes_on;
        accepted = true;
        damping = damping > 1e-3 ? damping * 0.1 : 0.0;
      } else {
        damping = damping > 0.0 ? damping * 10.0 : 1e-2;
      }
    }
    if (!accepted || step_in_sigma < options.step_tolerance) {
      fit.converged = !given_up && (accepted || step_in_sigma < 1.0);
      break;
    }
  }
  fit.information = here.information;
  fit.covariance = CovarianceOf(fit.information + prior.information);
  return fit;
}

}  // namespace faultlab::core
