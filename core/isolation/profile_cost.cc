#include "core/isolation/profile_cost.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <limits>

namespace faultlab::core {
namespace {

// From "short circuit" to "open" for each part.
constexpr std::array<ValueRange, kComponentCount> kRanges = {{
    {0.02, 3e3, 22},
    {500.0, 5e6, 22},
    {20.0, 1e6, 24},
    {1e-8, 5e-3, 24},
    {0.05, 2e3, 22},
    {3e-9, 1e-3, 24},
    {1e-8, 1e-2, 22},
}};

double McVariance(const FitContext& context) {
  Eigen::MatrixXd information = context.calibration.information;
  information.diagonal().array() += 1e-9;
  const Eigen::MatrixXd covariance =
      information.ldlt().solve(Eigen::MatrixXd::Identity(kCoordinateCount, kCoordinateCount));
  const auto mc = static_cast<Eigen::Index>(Coordinate::kMc);
  return covariance(mc, mc) * kMcUnitNm * kMcUnitNm;
}

}  // namespace

ValueRange RangeOf(Component component) {
  return kRanges[static_cast<std::size_t>(component)];
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
