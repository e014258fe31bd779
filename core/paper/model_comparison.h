#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/plant/coefficients.h"
#include "core/plant/model_fit.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// The five models that the paper compares with a measured output (Tables 13-20, Figure 23).
struct ModelsToCompare {
  DiscreteCoefficients swa;    ///< Eq. (8)
  ContinuousCoefficients sia;  ///< Eq. (6), b0, b1, a1 as the paper's rule gives them
  PlantParameters plant;       ///< Eq. (3)-(5) with Mc = 0, 0.48 and 0.33 mNm
};

struct ComparedFit {
  std::string name;  ///< "swa", "sia", "mc_0", "mc_0.48mNm", "mc_0.33mNm"
  ModelFit fit;
};

/// Simulated outputs and fits over `stretch`, in the order of the names above. As in the paper, all
/// five compute the output at the edge of its input (delta = 0); the initial states are estimated
/// by least squares. A model that cannot be simulated has a NaN fit.
std::vector<ComparedFit> CompareModels(const ModelsToCompare& models,
                                       std::span<const Sample> stretch,
                                       double period_s);

/// The columns of a stretch.
std::vector<double> ControlVoltages(std::span<const Sample> stretch);
std::vector<double> MotorVoltages(std::span<const Sample> stretch);

}  // namespace faultlab::core
