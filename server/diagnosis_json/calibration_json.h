#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <optional>
#include <string_view>

#include "core/bench/bench.h"
#include "core/types/calibration.h"
#include "core/types/result.h"

namespace faultlab::server {

/// {"version","dated","from_s","to_s","samples","period_s","used_um","used_ia","used_n","delta_s",
/// "gain_factor","nominal":{"R1":..},"constants":{"Ke":..},"mc_nm",..,"quantities":[..],
/// "checks":[..],"thresholds":{..},"covariance":[64 numbers],
/// "covariance_doubt":[64 numbers],"covariance_model":[..]}: everything that CalibrationFromJson
/// needs to restore the same calibration, except the last digit.
boost::json::object ToJson(const core::Calibration& calibration, const core::Bench& bench);

/// Reads the output of ToJson, or an object that contains it as "calibration" (the output of
/// `diagnose --json`). Refuses, naming the member, missing and implausible numbers and any other
/// version of the format. `name` precedes the message.
core::Result<core::Calibration> CalibrationFromJson(const boost::json::value& value,
                                                    std::string_view name,
                                                    const core::Bench& bench);

/// Parses a text. Refuses text that is not JSON.
core::Result<core::Calibration> ParseCalibration(std::string_view text,
                                                 std::string_view name,
                                                 const core::Bench& bench);

/// kInvalid, field "calibration", when there is one and it is not for this period.
core::Status CheckPeriod(const std::optional<core::Calibration>& calibration, double period_s);

}  // namespace faultlab::server
