#pragma once

#include <Eigen/Core>

#include "core/isolation/fit_context.h"

namespace faultlab::core {

/// Standard error of log(value): the root of the sum of three variances,
///   what the fit leaves open   (J'J + information)^-1 at `row`
///   the tolerance scale        l' tolerance_covariance l,  l = d log(value) / d(prior mean)
///   R9 and R12 alone           an offset of the measured gain belongs to one of five resistors,
///                              and a faulty one has taken its own offset with it
/// @param fit  of row + 1 or more logarithms of values, and of the eight coordinates at its end
/// @param value  SI unit of `component`
double LogSigma(const FitContext& context,
                const MapFit& fit,
                Eigen::Index row,
                Component component,
                double value);

/// The third of these for C8, whose time constant is C8 (Re2 + R5): how far log(C8) moves when the
/// resistors of Re2 are one tolerance off and the measured gain is kept. Fits again: three steps at
/// most.
/// @param point  [9] the fitted log(C8) and coordinates;  @param prior  that they were fitted under
double CapacitorLogSigma(const FitContext& context,
                         const GaussianPrior& prior,
                         const Eigen::VectorXd& point);

}  // namespace faultlab::core
