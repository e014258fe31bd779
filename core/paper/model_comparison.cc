#include "core/paper/model_comparison.h"

namespace faultlab::core {
namespace {

constexpr double kNoDelayS = 0.0;

}  // namespace

std::vector<double> ControlVoltages(std::span<const Sample> stretch) {
  std::vector<double> uc_v;
  uc_v.reserve(stretch.size());
  for (const Sample& sample : stretch) {
    uc_v.push_back(sample.uc_v);
  }
  return uc_v;
}

std::vector<double> MotorVoltages(std::span<const Sample> stretch) {
  std::vector<double> um_v;
  um_v.reserve(stretch.size());
  for (const Sample& sample : stretch) {
    um_v.push_back(sample.um_v);
  }
  return um_v;
}

std::vector<ComparedFit> CompareModels(const ModelsToCompare& models,
                                       std::span<const Sample> stretch,
                                       double period_s) {
  const std::vector<double> uc_v = ControlVoltages(stretch);
  const std::vector<double> um_v = MotorVoltages(stretch);
  const ContinuousCoefficients plant = MakeContinuous(models.plant);
  const auto with_friction = [&](double mc_nm) {
    return FitFriction(plant, mc_nm, uc_v, um_v, period_s, kNoDelayS);
  };
  return {{"swa", FitDiscrete(models.swa, uc_v, um_v)},
          {"sia", FitContinuous(models.sia, uc_v, um_v, period_s, kNoDelayS)},
          {"mc_0", with_friction(0.0)},
          {"mc_0.48mNm", with_friction(0.48e-3)},
          {"mc_0.33mNm", with_friction(0.33e-3)}};
}

}  // namespace faultlab::core
