#pragma once

#include <span>
#include <vector>

#include "core/isolation/fit_context.h"
#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {

/// The input of the parts of the isolation: two seconds of a bench that has one fault from the
/// start, with the parameters and the noise of the simulator and the given uncertainty of each
/// coordinate.
class FaultStretch {
 public:
  FaultStretch(const std::vector<Fault>& faults,
               std::uint64_t seed,
               double coordinate_sd = 0.01,
               Channels channels = Channels::kAll)
      : observations_(MakeObservations(Between(BenchRecord(faults, seed, 6.0), 3.0, 5.0),
                                       paper::Bench().readings(),
                                       channels,
                                       0.01,
                                       10.0)) {
    context.rig = paper::Rig();
    context.noise = paper::Noise();
    context.rig.mc_nm = 0.33e-3;
    context.noise.w_rad_s = 0.5 * paper::kRadPerSecondOfRpm;
    context.calibration.mean = Eigen::VectorXd::Zero(kCoordinateCount);
    context.calibration.information =
        Eigen::MatrixXd::Identity(kCoordinateCount, kCoordinateCount) /
        (coordinate_sd * coordinate_sd);
    context.stretch = observations_;
  }
  FaultStretch(const FaultStretch&) = delete;
  FaultStretch& operator=(const FaultStretch&) = delete;

  FitContext context;

 private:
  std::vector<Observation> observations_;
};

}  // namespace faultlab::core
