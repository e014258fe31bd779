// A recording as a file: CSV, MATLAB, JSON.
#include <boost/json.hpp>

#include "core/diagnosis/diagnose_record.h"
#include "server/api/run/columns.h"
#include "server/api/run/handlers.h"
#include "server/csv/bench_comment.h"
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
  const core::Bench& bench = *recording.value().options.bench;
  CsvWriteOptions options;
  options.comments = {
      "faultlab run " + record.id + ", rig " + record.rig + ", " + Iso8601(record.created_at),
      BenchComment(bench),
      "plan " + record.plan_json,
      "loop " + LoopText(events.value())};
  auto out = api.MakeSpool();
  FormatCsv(
      recording.value().samples, options, [&out](std::string_view piece) { out->Append(piece); });
  return Download(std::move(out), "text/csv; charset=utf-8", FileName(record, ".csv"));
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
  const core::Bench& bench = *recording.value().options.bench;
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
  for (std::size_t i = 0; i < events.value().size(); ++i) {
    if (i > 0) out.push_back(',');
    out.append(events.value()[i].json);
  }
  out.append("],\"loop\":").append(LoopText(events.value()));
  out.append(",\"diagnosis\":");
  out.append(record.diagnosis_json.empty() ? "null" : record.diagnosis_json);
  auto file = api.MakeSpool();
  file->Append(out);
  AppendSampleColumns(*file, recording.value().samples);
  file->Append("}");
  return Download(std::move(file), "application/json", FileName(record, ".json"));
}

core::Result<HttpResponse> ExportMat(RunApi& api, const ApiRequest& request) {
  auto recording = api.recordings.Load(request.run);
  if (!recording) return recording.error();
  const RunRecord& record = recording.value().record;
  RecordingExport all;
  all.name = record.name;
  all.origin = "faultlab run " + record.id + ", rig " + record.rig;
  all.period_s = record.period_s;
  all.samples = recording.value().samples;
  all.each_frame = [&](const std::function<void(const core::Frame&)>& each) {
    core::ReplayEstimates(recording.value().samples, recording.value().options, each);
  };
  boost::system::error_code ec;
  all.diagnosis = json::parse(record.diagnosis_json, ec);
  auto out = api.MakeSpool();
  WriteMat(all, *out);
  return Download(std::move(out), "application/x-matlab-data", FileName(record, ".mat"));
}

}  // namespace faultlab::server
