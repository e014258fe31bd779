#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "core/bench/bench.h"
#include "core/filter/map_fit.h"
#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"

namespace faultlab::core {

/// How far the zeros of um (V), ia (A) and w (rad/s) may be off: the units of the last three
/// coordinates of a fit.
std::array<double, kOutputCount> ZeroUnitsOf(const Bench& bench);

/// The rig at a point of a fit: the coordinates of WithOffsets, then the zeros of the channels.
RigParameters RigAt(const Bench& bench,
                    const RigParameters& base,
                    const Eigen::VectorXd& point,
                    double period_s);

/// The most likely rig for a stretch whose noise is known.
/// @param base   what the coordinates are offsets of
/// @param start  the coordinates with which the search begins
MapFit FitRig(const Bench& bench,
              const RigParameters& base,
              const NoiseLevel& noise,
              double period_s,
              std::span<const Observation> stretch,
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
/// @param mask        bit c: the stretch has readings of channel c
/// @param measured_delta_s  what the rig says of its delta; none: the description's is expected
Explained ExplainStretch(const Bench& bench,
                         const RigParameters& data_sheet,
                         double period_s,
                         std::span<const Observation> stretch,
                         unsigned mask,
                         const GaussianPrior& prior,
                         std::optional<double> measured_delta_s);

}  // namespace faultlab::core
