#pragma once

#include <boost/json/object.hpp>
#include <optional>
#include <string>

#include "core/diagnosis/diagnosis.h"
#include "server/api/api.h"

namespace faultlab::server {

/// {"diagnose": {"recording": ID, "values": "none"|"table2", "channels": "all"|"um",
/// "healthy_from_s", "healthy_to_s", "false_alarms_per_day", "motor_faults"}}: what a job does that
/// makes no run. The settings are those of `faultlab diagnose`.
struct DiagnoseJob {
  std::string recording;
  core::DiagnoseOptions options;
};

/// nullopt when the body asks for a run. Errors name the field.
core::Result<std::optional<DiagnoseJob>> ParseDiagnoseJob(const boost::json::object& body);
/// May `who` read the recording? Refusals are those of reading it.
core::Status CheckDiagnoseJob(ApiContext& api, const Principal& who, const DiagnoseJob& job);
/// Loads, diagnoses, fits models; the object of `faultlab diagnose --json` as text. Blocks: about
/// 3 us a sample and the fits.
core::Result<std::string> RunDiagnoseJob(ApiContext& api,
                                         const Principal& who,
                                         const DiagnoseJob& job);

}  // namespace faultlab::server
