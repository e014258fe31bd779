#include "core/isolation/profile_cost.h"

#include <array>
#include <cmath>
#include <limits>

#include "core/numerics/linear_systems.h"

namespace faultlab::core {
namespace {

double McVariance(const FitContext& context) {
  const Eigen::MatrixXd covariance = CovarianceOf(context.calibration.information);
  const auto mc = static_cast<Eigen::Index>(Coordinate::kMc);
  return covariance(mc, mc) * context.rig.mc_unit_nm * context.rig.mc_unit_nm;
}

}  // namespace

ValueRange RangeOf(Component component) {
  const ComponentInfo& info = component.info();
  return {info.value_min, info.value_max, info.scan_points};
}

ProfileCost::ProfileCost(const FitContext& context)
    : context_(context), mc_information_(1.0 / McVariance(context)) {}

const std::vector<ProfileCost::Result>& ProfileCost::At(std::span<const Point> points,
                                                        std::span<const Observation> stretch) {
  const std::size_t n = points.size();
  models_.resize(n);
  segments_.resize(n);
  paths_.resize(n);
  sums_.resize(n);
  results_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    models_[i] = context_.ModelOf(
        WithComponent(context_.rig, points[i].component, std::exp(points[i].log_value)));
    segments_[i] = {0, &models_[i]};
    paths_[i] = ModelPath(&segments_[i], 1);
  }
  RunWithMcResponse(paths_, stretch, sums_);
  for (std::size_t i = 0; i < n; ++i) {
    const InnovationSummary& sum = sums_[i];
    const double gain = sum.mc_cross * sum.mc_cross / (sum.mc_square + mc_information_);
    const double cost = sum.cost() - gain;
    results_[i] = {
        std::isfinite(cost) ? cost : std::numeric_limits<double>::max(), sum.chi2, sum.count};
  }
  return results_;
}

}  // namespace faultlab::core
