#pragma once

#include "core/isolation/hypothesis.h"

namespace faultlab::core {

/// Standard error of log(value), unknown `row` of a fit whose last eight are the calibration's
/// coordinates. Counts what the fit leaves open, what doubt about the calibration adds, and that
/// nobody knows which resistor an offset of the measured gain belongs to.
double LogSigma(const FitContext& context,
                const MapFit& fit,
                Eigen::Index row,
                const HypothesisFit& h);

/// The last of these for C8, whose time constant is C8 (Re2 + R5): how far its fit, value and
/// coordinates under `prior`, moves with Re2 a tolerance off.
double CapacitorLogSigma(const FitContext& context,
                         const GaussianPrior& prior,
                         const Eigen::VectorXd& point);

}  // namespace faultlab::core
