#pragma once

#include <array>
#include <vector>

#include "core/types/component.h"
#include "core/types/plant_parameters.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// {b0, b1 (s), a1 (s)} of the first-order amplifier model, paper Eq. (6).
using ContinuousTheta = std::array<double, 3>;

/// What one inverse method says if this component alone has changed.
struct InverseSolution {
  Component component = Component::kR1;
  bool exists = false;    ///< false: no positive value of the component fits
  double value = 0.0;     ///< SI unit of the component
  double mismatch = 0.0;  ///< |theta - model(value)| / |theta - nominal|, scaled per coefficient
};

/// The paper's isolation and identification beside each other, from one estimate of {b0, b1, a1}.
struct PaperMethods {
  ContinuousTheta nominal{};
  ContinuousTheta estimate{};
  ContinuousTheta band{};        ///< half width of the band around nominal
  std::vector<PathStep> path;    ///< decision algorithm, Fig. 21, as taken
  std::vector<Component> named;  ///< where the path ended
  std::array<InverseSolution, kComponentCount> single_column;  ///< Eq. (42), (43)
  std::array<InverseSolution, kComponentCount> exact;  ///< Eq. (4) inverted in one parameter
  int full_jacobian_rank = 0;                          ///< Eq. (35): 3 of 7, so R'R has no inverse
  double full_jacobian_condition = 0.0;  ///< of R'R with scaled columns; infinite in exact terms
  std::array<double, kComponentCount> full_jacobian_values{};  ///< pseudo-inverse, for the record
};

/// Eq. (4): {b0, b1, a1} of a plant.
ContinuousTheta FirstOrderTheta(const PlantParameters& plant, double gain_factor = 1.0);

/// Exact Jacobian d(b0, b1, a1) / d(R1, R9, R12, C8, Ra, J, B), Eq. (36)-(41) without the errata.
std::array<std::array<double, kComponentCount>, 3> FirstOrderJacobian(const PlantParameters& plant);

/// Runs all of it. @param band  half width of each coefficient's band (> 0), e.g. 4 sigma.
PaperMethods RunPaperMethods(const PlantParameters& nominal,
                             const ContinuousTheta& nominal_theta,
                             const ContinuousTheta& estimate,
                             const ContinuousTheta& band);

}  // namespace faultlab::core
