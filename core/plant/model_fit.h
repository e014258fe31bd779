#pragma once

#include <span>
#include <vector>

#include "core/plant/coefficients.h"
#include "core/plant/sampled_model.h"
#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// MATLAB's compare: 100 (1 - |y - yhat| / |y - mean y|) in percent; may be negative. NaN when y is
/// constant or contains a non-finite sample, and when the sizes differ or are 0.
double CompareFit(std::span<const double> measured, std::span<const double> simulated);

/// A simulated output with the initial state that fits the measurement best.
struct ModelFit {
  double fit_percent = 0.0;
  std::vector<double> simulated;
};

/// `y`: the measured channel that the models are of, um (V) or ia (A).
/// Simulated output (not a one-step prediction) of y(k) = b0d u(k) + b1d u(k-1) - a1d y(k-1). The
/// initial state x1, with y(0) = b0d u(0) + x1, is found by least squares.
ModelFit FitDiscrete(const DiscreteCoefficients& model,
                     std::span<const double> uc_v,
                     std::span<const double> y);

/// The same for the continuous model, whose output is read `delta_s` after the edge of its input
/// (delta = 0 is how the paper uses an SIA estimate).
ModelFit FitContinuous(const ContinuousCoefficients& model,
                       std::span<const double> uc_v,
                       std::span<const double> y,
                       double period_s,
                       double delta_s);

/// Eq. (3): transfer function from Uc minus the friction channel b02/(a12 s + 1) with constant Mc,
/// times `directions` (FrictionDirections) if there are any. Both initial states by least squares.
ModelFit FitFriction(const ContinuousCoefficients& model,
                     double mc_nm,
                     std::span<const double> uc_v,
                     std::span<const double> y,
                     double period_s,
                     double delta_s,
                     std::span<const double> directions = {});

/// Output `row` of the exact sampled plant (SampledModel::c) with friction Mc, which turns around
/// with the motor (FrictionDirections); three initial states by least squares.
ModelFit FitSampled(const SampledModel& model,
                    int row,
                    double mc_nm,
                    std::span<const double> uc_v,
                    std::span<const double> y);

}  // namespace faultlab::core
