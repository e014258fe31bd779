#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/bench/bench.h"
#include "core/filter/map_fit.h"
#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// The zero of a channel as a coordinate of a fit.
struct ZeroCoordinate {
  std::size_t channel = 0;  ///< of Observation::y
  double unit = 0.0;        ///< how far it may be off, one standard deviation: V, A, rad/s
};

/// A stretch without a fault, and what is learnt from it.
struct HealthyStretch {
  const Bench* bench = nullptr;  ///< never null
  double period_s = 0.01;
  std::span<const Observation> samples;
  unsigned mask = 0;  ///< bit c: there are readings of channel c
  std::vector<ZeroCoordinate> zeros;
};

/// The zeros that a stretch with readings of these channels may have.
std::vector<ZeroCoordinate> ZerosToLearn(const Bench& bench, unsigned mask);

/// The rig at a point of a fit: the coordinates of WithOffsets, then those of stretch.zeros.
RigParameters RigAt(const HealthyStretch& stretch,
                    const RigParameters& base,
                    const Eigen::VectorXd& point);

/// The most likely rig for a stretch whose noise is known.
/// @param base   what the coordinates are offsets of
/// @param start  the coordinates with which the search begins
MapFit FitRig(const HealthyStretch& stretch,
              const RigParameters& base,
              const NoiseLevel& noise,
              const GaussianPrior& prior,
              const Eigen::VectorXd& start);

/// The rig and the noise that explain a stretch best together.
struct Explained {
  RigParameters base;  ///< what fit.point is an offset of
  MapFit fit;
  NoiseLevel noise;
  double cost = 0.0;  ///< fit.cost() and that of the friction's noise
};

/// Fits the rig, from several delays, and the noise in turn.
/// @param data_sheet  the rig without offsets; its delta is not used
/// @param expected_delta_s  none: what the bench expects
Explained ExplainStretch(const HealthyStretch& stretch,
                         const RigParameters& data_sheet,
                         const GaussianPrior& prior,
                         std::optional<double> expected_delta_s);

}  // namespace faultlab::core
