#include "server/cli/calibrate.h"

#include <algorithm>
#include <boost/json/serialize.hpp>
#include <iterator>
#include <vector>

#include "core/calibration/calibrate.h"
#include "server/api/iso8601.h"
#include "server/cli/console.h"
#include "server/clock.h"
#include "server/csv/csv_record.h"
#include "server/csv/file_io.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/diagnosis_json/diagnosis_json.h"

namespace faultlab::server {
int RunCalibrate(const CalibrateOptions& options) {
  const core::Result<core::DiagnosisOptions> parsed = ParseFlags(options.flags);
  if (!parsed) {
    return Fail(parsed.error(), kExitBadInput);
  }
  if (!(options.false_alarms_per_day > 0.0)) {
    PrintError("--false-alarms must be above 0, for example 1 a day");
    return kExitBadInput;
  }
  const core::Result<CsvRecord> record = ReadCsv(options.recording);
  if (!record) {
    return Fail(record.error(), kExitBadInput);
  }
  for (const std::string& note : record.value().notes) {
    PrintError("note: " + note);
  }
  std::vector<core::Sample> stretch;
  std::copy_if(record.value().samples.begin(),
               record.value().samples.end(),
               std::back_inserter(stretch),
               [&](const core::Sample& sample) {
                 return sample.t_s >= parsed.value().healthy_from_s &&
                        sample.t_s < parsed.value().healthy_to_s;
               });
  core::CalibrationOptions calibrate;
  calibrate.data_sheet = parsed.value().nominal;
  calibrate.channels = parsed.value().channels;
  calibrate.period_s = record.value().period_s;
  calibrate.false_alarms_per_day = options.false_alarms_per_day;
  core::Result<core::Calibration> calibration = core::Calibrate(stretch, calibrate);
  if (!calibration) {
    PrintError(options.recording + ": " + calibration.error().message);
    return kExitBadInput;
  }
  calibration.value().dated = options.dated.empty() ? Iso8601(SystemClock().Wall()) : options.dated;
  if (!options.output.empty()) {
    const core::Status written =
        WriteFile(options.output, boost::json::serialize(ToJson(calibration.value())) + "\n");
    if (!written) {
      return Fail(written.error(), kExitFailure);
    }
    if (options.output == "-") {
      return kExitOk;
    }
  }
  return Print(ToText(calibration.value(), options.recording));
}

}  // namespace faultlab::server
