#include "tests/bench/study_bound.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "core/filter/innovation_filter.h"
#include "tests/paper_bench.h"

namespace faultlab::study {

using namespace core;

namespace {

// The rig is known to a tenth of the tolerances of core/calibration/calibrate.cc, the least that a
// calibration can reach; Mc and delta as there.
constexpr ParameterOffsets kTolerance = {0.005, 0.005, 0.005, 0.005, 0.02, 0.003, 2.0, 3.5};
constexpr double kStep = 1e-4;
constexpr double kFromS = 0.5;

}  // namespace

double CramerRaoSd(const RigParameters& rig,
                   const NoiseLevel& noise,
                   const Fault& fault,
                   std::span<const Sample> record,
                   Channels channels) {
  const std::vector<Observation> all =
      MakeObservations(record, paper::Bench().readings(), channels, paper::kPeriodS, 10.0);
  const auto from = static_cast<std::size_t>(std::lround(kFromS * (1.0 / paper::kPeriodS)));
  const auto stretch = std::span<const Observation>(all).subspan(from);
  const auto onset =
      static_cast<std::size_t>(std::ceil(fault.at_s * (1.0 / paper::kPeriodS) - 1e-6)) - from;
  const auto run = [&](int moved, InnovationTrace& trace) {
    ParameterOffsets q{};
    if (moved < kCoordinateCount && moved >= 0) q[static_cast<std::size_t>(moved)] = kStep;
    RigParameters healthy = WithOffsets(rig, q, paper::kPeriodS);
    RigParameters faulty = healthy;
    // An offset of the coordinate that belongs to the component changes its healthy value only; the
    // faulty value stays.
    const double value = fault.value * std::exp(moved == kCoordinateCount ? kStep : 0.0);
    faulty.plant.Set(fault.component, value);
    const PredictionModel before = MakePredictionModel(healthy, noise, paper::kPeriodS);
    const PredictionModel after = MakePredictionModel(faulty, noise, paper::kPeriodS);
    const std::array<ModelSegment, 2> segments = {
        {{0, &before}, {onset, &after, fault.component == paper::kC8}}};
    RunInnovations(segments, stretch, &trace);
  };
  InnovationTrace base;
  run(-1, base);
  constexpr int kUnknown = kCoordinateCount + 1;
  Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(base.whitened.size()), kUnknown);
  InnovationTrace moved;
  for (int i = 0; i < kUnknown; ++i) {
    run(i, moved);
    for (std::size_t r = 0; r < base.whitened.size(); ++r) {
      jacobian(static_cast<Eigen::Index>(r), i) = (moved.whitened[r] - base.whitened[r]) / kStep;
    }
  }
  Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  for (int i = 0; i < kCoordinateCount; ++i) {
    const double sd = kTolerance[static_cast<std::size_t>(i)];
    information(i, i) += 1.0 / (sd * sd);
  }
  information(kCoordinateCount, kCoordinateCount) += 1e-6;
  Eigen::VectorXd unit = Eigen::VectorXd::Unit(kUnknown, kCoordinateCount);
  return std::sqrt(information.ldlt().solve(unit)(kCoordinateCount));
}

}  // namespace faultlab::study
