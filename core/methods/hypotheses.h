#pragma once

#include <functional>
#include <vector>

#include "core/methods/method.h"

namespace faultlab::core {

/// The calibrated rig with another value of one component; log: of the value in its SI unit.
PredictionModel ModelOf(const MethodTask& task, Component component, double log_value);
/// The calibrated rig.
PredictionModel HealthyModel(const MethodTask& task);
/// The same with the noise that detection must allow for, see DetectionNoiseOf.
PredictionModel WatchedModel(const MethodTask& task);
/// Where a search for a changed value begins: the calibrated value, or for a capacitor that is
/// invisible when healthy, a value that is just not visible.
double LogStart(const MethodTask& task, Component component);

/// The same, or a capacitor's least visible value.
double LogVisible(const MethodTask& task, Component component);

/// The components of the bench without those whose small changes have the same effect on the fitted
/// channel as an earlier one's (two resistors of one gain): a joint estimate of both does not
/// exist.
std::vector<Component> DistinctComponents(const MethodTask& task);

/// A value searched over the range of the component: the points of its scan, then a golden section
/// around the best. `cost` of (component, log value).
MethodCandidate SearchValue(Component component,
                            const std::function<double(Component, double)>& cost);
/// The same where the costs of the scan are known already, by point.
MethodCandidate SearchValue(Component component,
                            const std::vector<double>& scan,
                            const std::function<double(Component, double)>& cost);

}  // namespace faultlab::core
