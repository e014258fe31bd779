#pragma once

#include <vector>

#include "core/filter/rig_parameters.h"
#include "core/types/component.h"
#include "core/types/plant_parameters.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// One fault of a set that is to be judged.
struct FaultSize {
  Component component = Component::kR1;
  double value = 1.0;  ///< SI unit of the component, > 0
};

/// What a fault set is judged on: a rig, an input, its noise, and how long one waits.
struct IsolabilityOptions {
  RigParameters rig;  ///< healthy
  NoiseLevel noise;   ///< of the readings, and the friction's slow part
  Channels channels = Channels::kUmOnly;
  std::vector<double> uc_v;  ///< input; the fault sets in where the last `window_samples` begin
  int window_samples = 100;  ///< samples of the fault that may be used, 1 .. uc_v.size() - 10
  double period_s = kSamplePeriodSeconds;
  double false_alarms_per_day = 1.0;    ///< of one test at every sample
  double detection_probability = 0.9;   ///< what "visible" asks for, (0.5, 1)
  double confusion_probability = 0.01;  ///< at most, for two faults to count as told apart
  std::vector<FaultSize> faults;        ///< empty: the 18 faults of the paper
};

}  // namespace faultlab::core
