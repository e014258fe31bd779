// A recording as a file: CSV, MATLAB, JSON, LCM log, notebook.
#include <algorithm>
#include <chrono>

#include "core/diagnosis/diagnose_record.h"
#include "hardware/lcm/lcm_log.h"
#include "hardware/lcm/rig_name.h"
#include "server/api/run/columns.h"
#include "server/api/run/file_names.h"
#include "server/api/run/handlers.h"
#include "server/api/run/notebook.h"
#include "server/api/run/truth.h"
#include "server/csv/bench_comment.h"
#include "server/csv/csv_writer.h"
#include "server/experiment/plan_json.h"
#include "server/export/recording_export.h"
#include "server/json/kept_json.h"
#include "server/json/plain_numbers.h"
#include "server/run/run_messages.h"

namespace faultlab::server {
namespace {

/// Of all estimators at each sample.
RecordingExport EstimatesOf(const Recording& recording) {
  RecordingExport out;
  out.name = recording.record.name;
  out.origin = "faultlab run " + recording.record.id + ", rig " + recording.record.rig;
  out.period_s = recording.record.period_s;
  out.samples = recording.samples;
  out.each_frame = [&recording](const std::function<void(const core::Frame&)>& each) {
    core::ReplayEstimates(recording.samples, recording.options, each);
  };
  return out;
}

core::Result<HttpResponse> ExportCsv(Api& api, const ApiRequest& request) {
  TRY(const auto asked, QueryWord(request.http, "content", {"samples", "estimates"}));
  const std::string content = asked.value_or("samples");
  TRY(const auto run, RunForFile(request));
  TRY(auto recording, api.recordings.Load(run));
  auto out = api.MakeSpool();
  if (content == "samples") {
    TRY(const auto events, api.recordings.Events(run));
    FormatCsvOf(recording,
                events,
                api.recordings.StoryOf(run, events, Missing::kMade),
                [&out](std::string_view piece) { out->Append(piece); });
  } else {
    WriteEstimatesCsv(EstimatesOf(recording), *out);
  }
  return Download(
      std::move(out), "text/csv; charset=utf-8", FileNameOf(request.run, content, "csv"));
}

core::Result<HttpResponse> ExportJson(Api& api, const ApiRequest& request) {
  TRY(const auto run, RunForFile(request));
  TRY(auto recording, api.recordings.Load(run));
  const RunRecord& record = recording.record;
  TRY(const auto events, api.recordings.Events(record));
  std::string out = "{\"id\":\"" + record.id + "\",\"name\":";
  AppendJsonString(out, record.name);
  out.append(",\"rig\":");
  AppendJsonString(out, record.rig);
  const core::Bench& bench = *recording.options.bench;
  out.append(",\"bench\":");
  AppendJsonString(out, bench.id);
  out.append(",\"bench_name\":");
  AppendJsonString(out, bench.name);
  out.append(",\"state\":\"").append(Name(record.state));
  out.append("\",\"created_at\":\"").append(Iso8601(record.created_at));
  out.append("\",\"period_s\":");
  AppendNumber(out, record.period_s);
  out.append(",\"plan\":").append(record.plan_json);
  out.append(",\"events\":[");
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (i > 0) out.push_back(',');
    out.append(events[i].json);
  }
  out.append("],\"loop\":").append(LoopText(events));
  out.append(",\"story\":")
      .append(StoryText(api.recordings.StoryOf(record, events, Missing::kMade)));
  out.append(",\"diagnosis\":");
  out.append(record.diagnosis_json.empty() ? "null" : record.diagnosis_json);
  auto file = api.MakeSpool();
  file->Append(out);
  AppendSampleColumns(*file, recording.samples);
  file->Append("}");
  return Download(std::move(file), "application/json", FileNameOf(record, "all", "json"));
}

/// What the rig said of the run: samples and its events, without those of the diagnosis.
core::Result<HttpResponse> ExportLcmLog(Api& api, const ApiRequest& request) {
  TRY(const auto run, RunForFile(request));
  TRY(auto recording, api.recordings.Load(run));
  const RunRecord& record = recording.record;
  TRY(const auto events, api.recordings.Events(record));
  hardware::LcmRecord log;
  log.rig = hardware::IsRigName(record.rig) ? record.rig : "recording";
  log.run = record.id;
  for (const RecordedEvent& said : events) {
    const auto event = ToRigEvent(said, *recording.options.bench);
    if (event) log.events.push_back(*event);
  }
  std::ranges::stable_sort(log.events, {}, &hardware::RigEvent::index);
  log.samples = std::move(recording.samples);
  const auto begun_us =
      std::chrono::duration_cast<std::chrono::microseconds>(record.created_at.time_since_epoch());
  auto out = api.MakeSpool();
  hardware::FormatLcmLog(
      log, begun_us.count(), [&out](std::string_view piece) { out->Append(piece); });
  return Download(
      std::move(out), "application/octet-stream", FileNameOf(record, "samples-events", "lcm"));
}

core::Result<HttpResponse> ExportMat(Api& api, const ApiRequest& request) {
  TRY(const auto run, RunForFile(request));
  TRY(auto recording, api.recordings.Load(run));
  const RunRecord& record = recording.record;
  RecordingExport all = EstimatesOf(recording);
  all.diagnosis = ParsedOr(record.diagnosis_json);
  TRY(const auto events, api.recordings.Events(record));
  all.story = StoryText(api.recordings.StoryOf(record, events, Missing::kMade));
  auto out = api.MakeSpool();
  WriteMat(all, *out);
  return Download(
      std::move(out), "application/x-matlab-data", FileNameOf(record, "samples-estimates", "mat"));
}

core::Result<HttpResponse> ExportNotebook(Api& api, const ApiRequest& request) {
  TRY(const auto run, RunForFile(request));
  TRY(auto recording, api.recordings.Load(run));
  const RunRecord& record = recording.record;
  TRY(const auto events, api.recordings.Events(record));
  std::string csv;
  FormatCsvOf(recording,
              events,
              api.recordings.StoryOf(record, events, Missing::kMade),
              [&csv](std::string_view piece) { csv += piece; });
  auto out = api.MakeSpool();
  out->Append(NotebookText("# Run " + record.id + ", rig " + record.rig + "\n\n" +
                               Iso8601(record.created_at) + ". The recording is in this notebook.",
                           csv));
  return Download(
      std::move(out), "application/x-ipynb+json", FileNameOf(record, "notebook", "ipynb"));
}

}  // namespace

void FormatCsvOf(const Recording& recording,
                 std::span<const RecordedEvent> events,
                 const RunStory& story,
                 const std::function<void(std::string_view)>& take) {
  const RunRecord& record = recording.record;
  CsvWriteOptions options;
  options.comments = {
      "faultlab run " + record.id + ", rig " + record.rig + ", " + Iso8601(record.created_at),
      BenchComment(*recording.options.bench),
      "plan " + WithPlainNumbers(record.plan_json),
      "loop " + WithPlainNumbers(LoopText(events))};
  // What is handed out as a task does not bring its solution.
  if (!HidesFaults(record.plan_json)) {
    options.comments.push_back("story " + WithPlainNumbers(StoryText(story)));
  }
  FormatCsv(recording.samples, options, take);
}

std::span<const ApiRoute> ExportsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "runs/{id}/export.csv", kReadRun, kRun, ExportCsv, kNoBody, kTransfer}.Takes(
          "content truth"),
      ApiRoute{kGet, "runs/{id}/export.mat", kReadRun, kRun, ExportMat, kNoBody, kTransfer}.Takes(
          "truth"),
      ApiRoute{kGet, "runs/{id}/export.lcm", kReadRun, kRun, ExportLcmLog, kNoBody, kTransfer}
          .Takes("truth"),
      ApiRoute{kGet, "runs/{id}/export.json", kReadRun, kRun, ExportJson, kNoBody, kTransfer}.Takes(
          "truth"),
      ApiRoute{kGet, "runs/{id}/export.ipynb", kReadRun, kRun, ExportNotebook, kNoBody, kTransfer}
          .Takes("truth"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
