#pragma once

#include <Eigen/Core>

#include "core/isolation/fit_context.h"

namespace faultlab::core {

/// Standard error of log(value): the root of the sum of four variances,
///   error of the fit           (J'J + information)^-1 at `row`
///   error of tolerance scale   l' tolerance_covariance l,  l = d log(value) / d(prior mean)
///   resistors of the gain      a measured offset of the gain belongs to one of them; if that is
///                              the faulty resistor, the offset has gone with it
///   missing physics            l' model_covariance l, and that of the component's own coordinate:
///                              it moves what is measured as it has moved the calibration
/// @param fit  of row + 1 or more logarithms of values, and of the eight coordinates at its end
/// @param value  SI unit of `component`
double LogSigma(const FitContext& context,
                const MapFit& fit,
                Eigen::Index row,
                Component component,
                double value);

/// The third variance for a capacitor, whose lag is its value times resistors of the gain: the
/// change of log(value) when these resistors are off by one tolerance and the measured gain is
/// kept. Fits again, with at most three steps.
/// @param point  [9] the fitted log(value) and coordinates
/// @param prior  the prior of that fit
double CapacitorLogSigma(const FitContext& context,
                         Component capacitor,
                         const GaussianPrior& prior,
                         const Eigen::VectorXd& point);

}  // namespace faultlab::core
