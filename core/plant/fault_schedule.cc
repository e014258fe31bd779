#include "core/plant/fault_schedule.h"

#include <cmath>
#include <utility>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

// Sample times are multiples of the period, rounded: a fault at 0.3 s must act at sample 3 * 0.1.
constexpr double kTimeSlackS = 1e-9;

}  // namespace

Status Validate(const Fault& fault) {
  if (!(std::isfinite(fault.value) && fault.value > 0.0)) {
    return Refuse("fault_value_not_positive", "value");
  }
  if (!(std::isfinite(fault.at_s) && fault.at_s >= 0.0)) {
    return Refuse("fault_outside_run", "at_s");
  }
  if (fault.kind != FaultKind::kAbrupt &&
      !(std::isfinite(fault.until_s) && fault.until_s > fault.at_s)) {
    return Refuse("fault_end_outside", "until_s");
  }
  return Done{};
}

FaultSchedule::FaultSchedule(std::vector<Fault> faults, const PlantParameters& nominal)
    : faults_(std::move(faults)), nominal_(nominal), scheduled_(nominal) {
  for (const Fault& fault : faults_) {
    const Status status = Validate(fault);
    LAB_CHECK(status.ok(), Name(fault.component), status.error().message);
  }
}

double FaultSchedule::ValueAt(Component component, double t_s) const {
  double value = nominal_.Get(component);
  for (const Fault& fault : faults_) {
    if (fault.component != component || t_s < fault.at_s - kTimeSlackS) {
      continue;
    }
    switch (fault.kind) {
      case FaultKind::kAbrupt:
        value = fault.value;
        break;
      case FaultKind::kDrift: {
        const double part = std::min(1.0, (t_s - fault.at_s) / (fault.until_s - fault.at_s));
        const double from = nominal_.Get(component);
        value = part >= 1.0 ? fault.value : from + part * (fault.value - from);
        break;
      }
      case FaultKind::kIntermittent:
        if (t_s < fault.until_s - kTimeSlackS) {
          value = fault.value;
        }
        break;
    }
  }
  return value;
}

void FaultSchedule::Apply(double t_s, Plant& plant) {
  for (const Fault& fault : faults_) {
    const double value = ValueAt(fault.component, t_s);
    if (value == scheduled_.Get(fault.component)) {
      continue;
    }
    scheduled_.Set(fault.component, value);
    if (fault.kind == FaultKind::kDrift) {
      plant.Drift(fault.component, value);
    } else {
      plant.Set(fault.component, value);
    }
  }
}

}  // namespace faultlab::core
