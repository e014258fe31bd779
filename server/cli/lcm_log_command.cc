#include "server/cli/lcm_log_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

#include "hardware/bench/benches.h"
#include "hardware/lcm/lcm_log.h"
#include "hardware/lcm/rig_name.h"
#include "server/cli/console.h"
#include "server/cli/recording_source.h"
#include "server/csv/csv_writer.h"

namespace faultlab::server {
namespace {

std::vector<hardware::RigEvent> EventsOf(const SourceRecording& source) {
  std::vector<hardware::RigEvent> events;
  for (const core::Fault& fault : source.faults) {
    hardware::RigEvent event;
    event.kind = hardware::RigEventKind::kFaultCommanded;
    event.index = std::llround(fault.at_s / source.period_s);
    event.component = fault.component;
    event.value = fault.value;
    events.push_back(std::move(event));
  }
  std::ranges::stable_sort(events, {}, &hardware::RigEvent::index);
  return events;
}

}  // namespace

int RunLcmExport(const LcmExportOptions& options) {
  if (!hardware::IsRigName(options.rig)) {
    PrintError("--rig needs a name of 1 to 40 letters, digits, - and _");
    return kExitBadInput;
  }
  TRY_INPUT(const auto bench, hardware::LoadBench(options.bench));
  TRY_INPUT(auto source, LoadRecording(options.recording, options.data_dir, *bench));
  PrintNotes(source.notes);
  hardware::LcmRecord record;
  record.rig = options.rig;
  record.run = options.run.empty() ? source.name : options.run;
  record.events = EventsOf(source);
  record.samples = std::move(source.samples);
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const core::Status written = hardware::WriteLcmLog(
      options.output, record, std::chrono::duration_cast<std::chrono::microseconds>(now).count());
  return written ? kExitOk : Fail(written.error());
}

int RunLcmImport(const LcmImportOptions& options) {
  TRY_INPUT(const auto bench, hardware::LoadBench(options.bench));
  const core::Result<hardware::LcmRecord> record =
      hardware::ReadLcmLog(options.log, options.run, *bench);
  if (!record) return Fail(record.error());
  const hardware::LcmRecord& read = record.value();
  if (read.lost_samples > 0) {
    PrintError("note: " + std::to_string(read.lost_samples) +
               " samples were lost on the bus; their rows are missing");
  }
  PrintNotes(read.skipped.Sentences());
  CsvWriteOptions csv;
  csv.comments = {"rig " + read.rig + ", run " + read.run + ", from the LCM log " +
                  std::filesystem::path(options.log).filename().string()};
  for (const hardware::RigEvent& event : read.events) {
    csv.comments.push_back("event " + std::string(hardware::Name(event.kind)) + " at sample " +
                           std::to_string(event.index) +
                           (event.text.empty() ? "" : ": " + event.text));
  }
  return Ended(WriteCsv(options.output, read.samples, csv));
}

}  // namespace faultlab::server
