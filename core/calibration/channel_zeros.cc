#include "core/calibration/channel_zeros.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/calibration/data_sheet.h"

namespace faultlab::core {
namespace {

// Fall of the cost that is worth the zeros of the channels (chi-square with at most three degrees
// of freedom: 1 in 1000 above 16).
constexpr double kZeroGain = 16.0;

}  // namespace

std::optional<WithZeros> LearnZeros(const HealthyStretch& without,
                                    const RigParameters& data_sheet,
                                    const ParameterOffsets& tolerance,
                                    std::optional<double> expected_delta_s,
                                    const Explained& explained) {
  HealthyStretch stretch = without;
  stretch.zeros = ZerosToLearn(*stretch.bench, stretch.mask);
  if (stretch.zeros.empty()) return std::nullopt;
  const auto n = static_cast<int>(explained.fit.point.size());
  const auto zeros = static_cast<int>(stretch.zeros.size());
  const GaussianPrior prior = DataSheetPrior(tolerance, 1.0, n, zeros);
  Eigen::VectorXd start = Eigen::VectorXd::Zero(n + zeros);
  start.head(n) = explained.fit.point;
  const MapFit tried = FitRig(stretch, explained.base, explained.noise, prior, start);
  // One channel alone hardly tells its zero from friction; but there is no friction below zero.
  const double mc_nm = RigAt(without, explained.base, explained.fit.point).mc_nm;
  const double gain = std::popcount(stretch.mask) == 1 && mc_nm < 0.0 ? 0.0 : kZeroGain;
  if (!(tried.cost() + gain < explained.fit.cost())) return std::nullopt;
  Explained better = ExplainStretch(stretch, data_sheet, prior, expected_delta_s);
  return WithZeros{std::move(stretch), std::move(better)};
}

void AddZeros(const HealthyStretch& stretch,
              const RigParameters& rig,
              const Eigen::MatrixXd& covariance,
              std::vector<CalibratedQuantity>& quantities) {
  struct Channel {
    const char* name;
    const char* unit;
    double per_unit;  ///< of Observation::y
  };
  const std::array<Channel, kOutputCount> channels = {
      {{"um0", "V", 1.0},
       {"ia0", "A", 1.0},
       {"n0", "rpm", RadPerSecondOfRpm(stretch.bench->nominal.gear_ratio)}}};
  Eigen::Index at = covariance.rows() - static_cast<Eigen::Index>(stretch.zeros.size());
  for (const ZeroCoordinate& zero : stretch.zeros) {
    const Channel& channel = channels[zero.channel];
    const double share = std::sqrt(std::max(0.0, covariance(at, at)));
    const double sd = zero.unit / channel.per_unit;
    quantities.push_back({channel.name,
                          channel.unit,
                          rig.zeros[zero.channel] / channel.per_unit,
                          share * sd,
                          0.0,
                          sd,
                          share < 0.5});
    ++at;
  }
}

}  // namespace faultlab::core
