#include "server/cli/calibrate.h"
#include "server/diagnosis_json/channels_text.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/diagnosis/diagnosis_task.h"
#include "hardware/bench/benches.h"
#include "server/api/iso8601.h"
#include "server/cli/calibration_file.h"
#include "server/cli/console.h"
#include "server/clock.h"
#include "server/csv/bench_comment.h"
#include "server/csv/csv_record.h"
#include "server/diagnosis_json/diagnosis_json.h"

namespace faultlab::server {
int RunCalibrate(const CalibrateOptions& options) {
  TRY_INPUT(const auto bench, hardware::LoadBench(options.flags.bench));
  TRY_INPUT(auto diagnosis, ParseFlags(options.flags, *bench));
  if (!(options.false_alarms_per_day > 0.0)) {
    PrintError("--false-alarms must be above 0, for example 1 a day");
    return kExitBadInput;
  }
  TRY_INPUT(const auto record, ReadCsv(options.recording));
  PrintNotes(record.notes);
  NoteOtherBench(options.recording, BenchInComments(record.comments), options.flags.bench, *bench);
  TRY_INPUT(const auto notes,
            NotesOnRecord(record.channels, record.samples, *diagnosis.bench, options.recording));
  PrintNotes(notes);
  FollowRecord(options.flags, record.samples, record.period_s, diagnosis);
  std::vector<core::Sample> stretch;
  std::ranges::copy_if(
      record.samples, std::back_inserter(stretch), [&](const core::Sample& sample) {
        return sample.t_s >= diagnosis.healthy_from_s && sample.t_s < diagnosis.healthy_to_s;
      });
  core::CalibrationOptions calibrate = core::CalibrationOf(diagnosis);
  calibrate.false_alarms_per_day = options.false_alarms_per_day;
  core::Result<core::Calibration> calibration = core::Calibrate(stretch, calibrate);
  if (!calibration) {
    PrintError(options.recording + ": " + calibration.error().message);
    return kExitBadInput;
  }
  calibration.value().dated = options.dated.empty() ? Iso8601(SystemClock().Wall()) : options.dated;
  if (!options.output.empty()) {
    const int ended = Ended(WriteCalibrationFile(options.output, calibration.value(), *bench));
    if (ended != kExitOk || options.output == "-") return ended;
  }
  return Print(ToText(calibration.value(), options.recording));
}

}  // namespace faultlab::server
