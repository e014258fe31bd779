#pragma once

#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <string_view>

#include "core/types/calibration.h"
#include "core/types/result.h"

namespace faultlab::server {

/// {"version","dated","from_s","to_s","samples","period_s","used_ia","used_n","delta_s",
/// "gain_factor","nominal":{"R1":..},"constants":{"Ke":..},"mc_nm",..,"quantities":[..],
/// "checks":[..],"thresholds":{..},"covariance":[64 numbers],
/// "covariance_doubt":[64 numbers]}: all that CalibrationFromJson needs
/// to give the same calibration back, to the last digit but one.
boost::json::object ToJson(const core::Calibration& calibration);

/// Reads what ToJson wrote, or an object that holds it as "calibration" (the answer of
/// `diagnose --json`). Refuses, naming the member, what is missing or no plausible number, and any
/// other version of the format. `name` stands before the message.
core::Result<core::Calibration> CalibrationFromJson(const boost::json::value& value,
                                                    std::string_view name);

/// From text. Refuses what is no JSON.
core::Result<core::Calibration> ParseCalibration(std::string_view text, std::string_view name);

}  // namespace faultlab::server
