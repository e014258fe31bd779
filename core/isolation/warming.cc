#include "core/isolation/warming.h"

#include <algorithm>
#include <cmath>

#include "core/numerics/linear_systems.h"
#include "core/types/number_text.h"

namespace faultlab::core {
namespace {

constexpr double kRaPerRootSecond = 0.003;

}  // namespace

void Widen(const BenchNorm& norm, double seconds, GaussianPrior& prior) {
  const double ra = std::min(kRaPerRootSecond * std::sqrt(std::max(0.0, seconds)), norm.warming);
  Eigen::MatrixXd covariance = CovarianceOf(prior.information);
  for (const WarmingPart& walk : kWarmingParts) {
    const auto at = static_cast<Eigen::Index>(walk.coordinate);
    covariance(at, at) += walk.share * walk.share * ra * ra;
  }
  prior.information = InverseOfSymmetric(covariance);
}

bool IsWithinWarming(const BenchNorm& norm,
                     const PlantParameters& healthy,
                     const Candidate& candidate) {
  const double change = std::abs(std::log(candidate.value / healthy.Get(candidate.component)));
  const int parameter = candidate.component.info().parameter;
  return std::ranges::any_of(kWarmingParts, [&](const WarmingPart& walk) {
    return walk.parameter == parameter && change < walk.share * norm.warming;
  });
}

std::string WarmingSentence(const Eigen::VectorXd& shift) {
  const double ra = std::expm1(shift(static_cast<Eigen::Index>(Coordinate::kRa)));
  return Format("the winding has moved by %+.1f %%, as that of a rig that warms up or runs in does",
                100.0 * ra);
}

}  // namespace faultlab::core
