#pragma once

#include <vector>

#include "core/bench/bench.h"
#include "core/paper/theta.h"
#include "core/types/component.h"
#include "core/types/plant_parameters.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// The result of one inverse method under the assumption that only this component has changed.
struct InverseSolution {
  Component component{};
  bool exists = false;    ///< false: no positive value of the component fits
  double value = 0.0;     ///< SI unit of the component
  double mismatch = 0.0;  ///< |theta - model(value)| / |theta - nominal|, scaled per coefficient
};

/// The paper's isolation and identification methods side by side, from one estimate of {b0, b1,
/// a1}.
struct PaperMethods {
  ContinuousTheta nominal{};
  ContinuousTheta estimate{};
  ContinuousTheta band{};                      ///< half width of the band around nominal
  std::vector<PathStep> path;                  ///< the decisions taken in the algorithm of Fig. 21
  std::vector<Component> named;                ///< the components at the end of the path
  std::vector<InverseSolution> single_column;  ///< Eq. (42), (43)
  std::vector<InverseSolution> exact;          ///< Eq. (4) inverted in one parameter
  int full_jacobian_rank = 0;                  ///< Eq. (35): 3 of 7, so R'R has no inverse
  double full_jacobian_condition = 0.0;        ///< of R'R with scaled columns; infinite in theory
  std::vector<double> full_jacobian_values;    ///< pseudo-inverse, for the record
};

/// Eq. (4): {b0, b1, a1} of a plant.
ContinuousTheta FirstOrderTheta(const PlantParameters& plant, double gain_factor = 1.0);

/// Runs all methods for the components of `bench`; the path only where HasDecisions (decisions.h).
/// @param band  half width of each coefficient's band (> 0), e.g. 4 sigma
PaperMethods RunPaperMethods(const Bench& bench,
                             const PlantParameters& nominal,
                             const ContinuousTheta& nominal_theta,
                             const ContinuousTheta& estimate,
                             const ContinuousTheta& band);

}  // namespace faultlab::core
