#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/bench/bench.h"
#include "core/filter/observation.h"
#include "core/filter/rig_parameters.h"
#include "core/types/calibration.h"
#include "core/types/result.h"

namespace faultlab::core {

/// The checks before the fit: length, excitation, saturation. Appends the result of each check;
/// returns the first failure as a refusal. The channel that must be present is the one from which
/// the structure of `bench` is estimated.
std::optional<Error> CheckBefore(const Bench& bench,
                                 std::span<const Observation> stretch,
                                 double period_s,
                                 std::vector<CalibrationCheck>& checks);

/// The checks of the fitted model: plausible parameters and noise, the same rig from the first to
/// the last sample (stationarity), white innovations.
/// @param quantities   the rig's coordinates, in their order, then what channels read at zero
/// @param coordinates  how many the former are
std::optional<Error> CheckAfter(const Bench& bench,
                                const RigParameters& rig,
                                const NoiseLevel& noise,
                                double period_s,
                                std::span<const Observation> stretch,
                                double prior_cost,
                                const std::vector<CalibratedQuantity>& quantities,
                                std::size_t coordinates,
                                std::vector<CalibrationCheck>& checks,
                                ModelError& error);

}  // namespace faultlab::core
