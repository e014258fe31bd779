#pragma once

#include <string>
#include <string_view>

#include "core/diagnosis/diagnosis_options.h"
#include "core/types/result.h"

namespace faultlab::server {

/// {"nominal":{"R1":..},"constants":{..},"calibration":{..}|null,"healthy_from_s","healthy_to_s",
/// "channels":"all"|"um","values":"none"|"table2","motor_faults","period_s",
/// "false_alarms_per_day","um_rail_v"}: the options of a diagnosis as stored with a recording.
std::string OptionsText(const core::DiagnosisOptions& options);

/// Reads the output of OptionsText, exact except the last digit. A refusal names the member.
core::Result<core::DiagnosisOptions> ParseOptions(std::string_view text, const core::Bench& bench);

}  // namespace faultlab::server
