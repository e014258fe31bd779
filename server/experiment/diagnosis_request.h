#pragma once

#include <boost/json/object.hpp>
#include <cstddef>
#include <optional>
#include <string>

#include "core/diagnosis/diagnosis_options.h"
#include "server/experiment/recordings.h"

namespace faultlab::server {

/// Bounds of what a request on a stored recording may hold.
inline constexpr double kRecordingSecondsMax = 100'000.0;
inline constexpr std::size_t kRecordingIdBytesMax = 64;

/// {"diagnose": {"recording": ID, "values": "none"|"table2", "channels": "all"|"um",
/// "healthy_from_s", "healthy_to_s", "false_alarms_per_day", "motor_faults"}}: what a job does that
/// makes no run. The settings are those of `faultlab diagnose`.
struct DiagnosisRequest {
  std::string recording;
  core::Channels channels = core::Channels::kAll;
  core::ValuePrior values = core::ValuePrior::kNone;
  std::optional<double> healthy_from_s;  ///< nullopt: as the bench has it
  std::optional<double> healthy_to_s;
  double false_alarms_per_day = 1.0;
  bool motor_faults = true;
};

/// Errors name the field.
core::Result<DiagnosisRequest> ParseDiagnosisRequest(const boost::json::object& body);
/// May `who` read the recording? Refusals are those of reading it.
core::Status CheckDiagnosis(Recordings& recordings,
                            const Principal& who,
                            const DiagnosisRequest& request);
/// Loads, diagnoses, fits models; the object of `faultlab diagnose --json` as text. Blocks: about
/// 3 us a sample and the fits.
core::Result<std::string> Diagnose(Recordings& recordings,
                                   const Principal& who,
                                   const DiagnosisRequest& request);

}  // namespace faultlab::server
