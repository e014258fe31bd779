#pragma once

#include <string>
#include <string_view>

#include "core/diagnosis/diagnosis_options.h"
#include "core/types/result.h"

namespace faultlab::server {

/// {"nominal":{"R1":..},"constants":{..},"calibration":{..}|null,"healthy_from_s","healthy_to_s",
/// "channels":"all"|"um","values":"none"|"table2","motor_faults","period_s",
/// "false_alarms_per_day","um_rail_v"}: as a recording keeps the options of its diagnosis.
std::string OptionsText(const core::DiagnosisOptions& options);

/// Reads what OptionsText wrote, to the last digit but one. Refuses, naming the member.
core::Result<core::DiagnosisOptions> ParseOptions(std::string_view text);

}  // namespace faultlab::server
