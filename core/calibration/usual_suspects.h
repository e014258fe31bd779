#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "core/calibration/calibrate.h"
#include "core/types/calibration.h"
#include "core/types/result.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// Why a stretch does not fit its bench, when it is the record and not the rig: tries what people's
/// records have had wrong (a unit, the ratio of the gear, a sign, readings that come some rows late
/// or smoothed, a driver that takes a constant voltage) and names what makes the stretch pass all
/// checks: "it fits when n is multiplied by 9.549: is its unit rad/s?". What leaves least of the
/// record to the data sheet is tried first; where none of those passes, it may be that the
/// beginning fits, or a channel that the stretch fits without.
/// @param calibrate  judges a changed stretch, of the same options
/// Nothing: none of them is behind it. Cost: at most six calibrations of 15 s of the record, of
/// 60 s where its input seldom steps.
std::optional<std::string> UsualSuspect(
    std::span<const Sample> samples,
    const CalibrationOptions& options,
    const std::function<Result<Calibration>(std::span<const Sample>)>& calibrate);

/// A channel with far less noise than its description states, which has as much as stated when it
/// is taken for smoothed: alarms and values of such a record would be wrong. Nothing: there is
/// none.
/// @param as_it_is  of the samples
std::optional<std::string> SmoothedChannel(
    std::span<const Sample> samples,
    const CalibrationOptions& options,
    const Calibration& as_it_is,
    const std::function<Result<Calibration>(std::span<const Sample>)>& calibrate);

}  // namespace faultlab::core
