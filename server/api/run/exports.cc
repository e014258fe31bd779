// A recording as a file: CSV, MATLAB, JSON.
#include <boost/json.hpp>

#include "server/api/run/columns.h"
#include "server/api/run/handlers.h"
#include "server/csv/csv_writer.h"
#include "server/experiment/plan_json.h"
#include "server/export/recording_export.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

std::string FileName(const RunRecord& record, std::string_view extension) {
  return record.id + std::string(extension);
}

}  // namespace

core::Result<HttpResponse> ExportCsv(RunApi& api, const ApiRequest& request) {
  auto recording = api.recordings.Load(request.run);
  if (!recording) return recording.error();
  const RunRecord& record = recording.value().record;
  const auto events = api.recordings.Events(record);
  if (!events) return events.error();
  CsvWriteOptions options;
  options.comments = {
      "faultlab run " + record.id + ", rig " + record.rig + ", " + Iso8601(record.created_at),
      "plan " + record.plan_json,
      "loop " + LoopText(events.value())};
  return Download(FormatCsv(recording.value().samples, options),
                  "text/csv; charset=utf-8",
                  FileName(record, ".csv"));
}

core::Result<HttpResponse> ExportJson(RunApi& api, const ApiRequest& request) {
  auto recording = api.recordings.Load(request.run);
  if (!recording) return recording.error();
  const RunRecord& record = recording.value().record;
  const auto events = api.recordings.Events(record);
  if (!events) return events.error();
  std::string out = "{\"id\":\"" + record.id + "\",\"name\":";
  AppendJsonString(out, record.name);
  out.append(",\"rig\":");
  AppendJsonString(out, record.rig);
  out.append(",\"state\":\"").append(Name(record.state));
  out.append("\",\"created_at\":\"").append(Iso8601(record.created_at));
  out.append("\",\"period_s\":");
  AppendNumber(out, record.period_s);
  out.append(",\"plan\":").append(record.plan_json);
  out.append(",\"events\":[");
  for (std::size_t i = 0; i < events.value().size(); ++i) {
    if (i > 0) out.push_back(',');
    out.append(events.value()[i].json);
  }
  out.append("],\"loop\":").append(LoopText(events.value()));
  out.append(",\"diagnosis\":");
  out.append(record.diagnosis_json.empty() ? "null" : record.diagnosis_json);
  out.append(SampleColumns(recording.value().samples)).append("}");
  return Download(std::move(out), "application/json", FileName(record, ".json"));
}

core::Result<HttpResponse> ExportMat(RunApi& api, const ApiRequest& request) {
  auto recording = api.recordings.Load(request.run);
  if (!recording) return recording.error();
  const RunRecord& record = recording.value().record;
  std::vector<core::Frame> frames;
  frames.reserve(recording.value().samples.size());
  core::ReplayEstimates(recording.value().samples,
                        recording.value().options,
                        [&](const core::Frame& frame) { frames.push_back(frame); });
  RecordingExport all;
  all.name = record.name;
  all.origin = "faultlab run " + record.id + ", rig " + record.rig;
  all.period_s = record.period_s;
  all.samples = recording.value().samples;
  all.frames = frames;
  all.faults = FaultsOfPlan(record.plan_json);
  boost::system::error_code ec;
  all.diagnosis = json::parse(record.diagnosis_json, ec);
  return Download(server::ExportMat(all), "application/x-matlab-data", FileName(record, ".mat"));
}

}  // namespace faultlab::server
