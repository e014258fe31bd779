#pragma once

#include <span>
#include <vector>

#include "core/isolability/isolability_options.h"

namespace faultlab::core {

/// How well the value of one fault can be known.
struct ExpectedError {
  FaultSize fault;
  /// Standard error of log(value), one for each window that was asked for; the last ones may be
  /// better, never worse. Infinite when the window does not contain the value.
  std::vector<double> relative_sigma;
};

/// The standard errors of the values that a diagnosis finds, over rigs of the class, each of which
/// is known from its data sheet and from a healthy stretch:
///   A = J'J + diag(1/tolerance^2),   g_i = row 0 of A^-1 J' j_i
///   sigma^2 = (A^-1)_00 + sum over i of (tolerance of the gain)^2 g_i^2
/// J [readings x 1+n] holds the derivatives of the filter's whitened errors, over the stretch and
/// the window, by log(value) and by the n coordinates of the rig that a diagnosis learns. The first
/// term is the Cramer-Rao bound. j_i are the derivatives by the parts of the amplifier that
/// determine its gain, where these are several: a diagnosis learns their gain and not which of them
/// is off, so that a fault which replaces one of them takes its offset with it. Onset known, small
/// errors; no noise is simulated.
/// @param options         the input ends with the longest window; uc_v before it is the stretch
/// @param tolerance       one standard deviation of each Coordinate; 0 holds it
/// @param windows         samples of the fault, each 1 .. options.window_samples
/// Contract: options that AnalyseIsolability accepts. Some 0.1 s for 14 faults of 10 s at 100 Hz.
/// Source: Cramer-Rao bound with a prior, H. L. Van Trees, Detection, Estimation, and Modulation
/// Theory I (1968), section 2.4.
std::vector<ExpectedError> ExpectedErrors(const IsolabilityOptions& options,
                                          const ParameterOffsets& tolerance,
                                          std::span<const int> windows);

}  // namespace faultlab::core
