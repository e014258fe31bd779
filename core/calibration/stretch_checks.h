#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"
#include "core/types/calibration.h"
#include "core/types/result.h"

namespace faultlab::core {

/// What must hold before anything is fitted: length, excitation, saturation. Appends one check
/// each; returns the first that failed as a refusal.
std::optional<Error> CheckBefore(std::span<const Observation> stretch,
                                 std::vector<CalibrationCheck>& checks);

/// What must hold of the fitted model: plausible parameters and noise, the same rig from the first
/// to the last sample (stationarity), white innovations.
std::optional<Error> CheckAfter(const RigParameters& rig,
                                const NoiseLevel& noise,
                                double period_s,
                                std::span<const Observation> stretch,
                                double prior_cost,
                                const std::vector<CalibratedQuantity>& quantities,
                                std::vector<CalibrationCheck>& checks);

}  // namespace faultlab::core
