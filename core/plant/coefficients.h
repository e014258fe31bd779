#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "core/types/plant_parameters.h"

namespace faultlab::core {

/// First-order model of the amplifier with its motor, armature inductance neglected, second order
/// reduced to first (paper Eq. (3)-(7)), of the channel Y that the structure's estimators fit:
///   Y = (b1 s + b0)/(a1 s + 1) Uc - b02/(a12 s + 1) Mc
///   D = B (Ra+Rs) + Ke KT,  a12 = J (Ra+Rs)/D,  a1 = a12 + lag
///   um:  N = B Ra + Ke KT,  b0 = k N/D,  b1 = k (J Ra + lead N)/D,  b02 = Rs Ke/D
///   ia:                     b0 = k B/D,  b1 = k (J + lead B)/D,     b02 = -Ke/D
///   n:                      b0 = k KT/D, b1 = k lead KT/D,          b02 = (Ra+Rs)/D, times rpm
struct ContinuousCoefficients {
  double b0 = 0.0;   ///< V/V; of ia: A/V, of n: rpm/V
  double b1 = 0.0;   ///< s
  double a1 = 0.0;   ///< s
  double b02 = 0.0;  ///< V/Nm
  double a12 = 0.0;  ///< s
};

/// y(k) = b0d u(k) + b1d u(k-1) - a1d y(k-1), paper Eq. (8).
struct DiscreteCoefficients {
  double b0d = 0.0;
  double b1d = 0.0;
  double a1d = 0.0;
};

/// From an output of SampledModel, in SI units, to the unit of the channel that is estimated: 1, or
/// from rad/s of the motor shaft to rpm behind the gear.
double ReadingPerOutput(const PlantParameters& parameters);

/// Eq. (4), (5). Contract: all parameters positive.
ContinuousCoefficients MakeContinuous(const PlantParameters& parameters);

/// Exact sampling of (b1 s + b0)/(a1 s + 1) behind a hold of period T, the output read delta after
/// the edge of its own input, 0 <= delta < T:
///   e = exp(-T/a1),  a1d = -e,  b0d = b0 - (b0 - b1/a1) exp(-delta/a1),  b1d = b0 (1-e) - b0d
/// delta = 0 is the paper's Eq. (9). Contract: a1 > 0, T > 0.
DiscreteCoefficients Discretise(const ContinuousCoefficients& c, double period_s, double delta_s);

/// The exact inverse of Discretise:
///   a1 = -T/ln(-a1d),  b0 = (b0d+b1d)/(1+a1d),  b1 = a1 (b0 - (b0-b0d) exp(delta/a1))
/// b02 and a12 are 0, because the pair (u, y) does not determine them. Returns nothing when -a1d is
/// not inside (0, 1): then no stable first-order system has these samples.
std::optional<ContinuousCoefficients> MakeContinuous(const DiscreteCoefficients& d,
                                                     double period_s,
                                                     double delta_s);

/// Rows b0, b1, a1; a column for each requested component (paper Eq. (36)).
using CoefficientJacobian =
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kComponentsMax>;

/// d(b0, b1, a1)/d(components) of Eq. (4), closed form.
/// The paper prints it as Eq. (40), (41) with errors: see core/README.md, errata.
CoefficientJacobian ContinuousJacobian(const PlantParameters& parameters,
                                       std::span<const Component> components);

/// Rows b0d, b1d, a1d: the chain rule through Discretise.
CoefficientJacobian DiscreteJacobian(const PlantParameters& parameters,
                                     std::span<const Component> components,
                                     double period_s,
                                     double delta_s);

}  // namespace faultlab::core
