#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/diagnosis/diagnosis.h"
#include "server/api/handlers.h"
#include "server/api/replay_frames.h"
#include "server/api/run_body.h"
#include "server/csv/csv_writer.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/export/recording_export.h"
#include "server/stream/frame_codec.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::int64_t kIndexMax = 1'000'000'000;
constexpr std::size_t kRowsPerReviewFrame = 100;

struct Recording {
  RunRecord record;
  std::vector<core::Sample> samples;
};

core::Result<Recording> Load(ApiContext& api,
                             const ApiRequest& request,
                             std::int64_t from,
                             std::int64_t to) {
  auto record = AuthorizedRun(api, request, Operation::kReadRun);
  if (!record) return record.error();
  auto samples = api.store.LoadSamples(record.value().id, from, to);
  if (!samples) return samples.error();
  return Recording{std::move(record).value(), std::move(samples).value()};
}

/// Shortest text that reads back to the same bits; null for NaN.
void AppendNumber(std::string& out, double value) {
  if (!std::isfinite(value)) {
    out.append("null");
    return;
  }
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  out.append(text.data(), end);
}

template <typename Items, typename Get>
void AppendColumn(std::string& out, std::string_view name, const Items& items, Get get) {
  out.append(",\"").append(name).append("\":[");
  bool first = true;
  for (const auto& item : items) {
    if (!first) out.push_back(',');
    first = false;
    AppendNumber(out, get(item));
  }
  out.push_back(']');
}

std::string SampleColumns(std::span<const core::Sample> samples) {
  std::string out;
  out.reserve(samples.size() * 64);
  AppendColumn(out, "index", samples, [](const auto& s) { return static_cast<double>(s.index); });
  AppendColumn(out, "t_s", samples, [](const auto& s) { return s.t_s; });
  AppendColumn(out, "uc_v", samples, [](const auto& s) { return s.uc_v; });
  AppendColumn(out, "um_v", samples, [](const auto& s) { return s.um_v; });
  AppendColumn(out, "ua_v", samples, [](const auto& s) { return s.ua_v; });
  AppendColumn(out, "ia_a", samples, [](const auto& s) { return s.ia_a; });
  AppendColumn(out, "n_rpm", samples, [](const auto& s) { return s.n_rpm; });
  return out;
}

HttpResponse JsonText(std::string text) {
  HttpResponse response;
  response.body = std::move(text);
  return response;
}

std::string FileName(const RunRecord& record, std::string_view extension) {
  return record.id + std::string(extension);
}

void AppendReviewFrame(std::string& out,
                       std::span<const StreamRow> rows,
                       std::int64_t first,
                       double t_s) {
  const std::string frame = EncodeFrameMessage(rows, first, t_s);
  const auto size = static_cast<std::uint32_t>(frame.size());
  std::array<char, sizeof size> prefix;
  std::memcpy(prefix.data(), &size, sizeof size);
  out.append(prefix.data(), prefix.size()).append(frame);
}

/// What the loop of the rig was like, as one JSON object: the run's last event carries it.
std::string LoopText(std::span<const RecordedEvent> events) {
  for (const RecordedEvent& event : events) {
    if (event.kind != "finished" && event.kind != "stopped") continue;
    boost::system::error_code ec;
    const json::value parsed = json::parse(event.json, ec);
    const json::object* object = ec ? nullptr : parsed.if_object();
    const json::value* loop = object != nullptr ? object->if_contains("loop") : nullptr;
    if (loop != nullptr) return json::serialize(*loop);
  }
  return "null";
}

/// The diagnosis of an ended run that has none yet (cut by a crash): made now, and kept.
core::Result<std::string> DiagnoseStored(ApiContext& api, const RunRecord& record) {
  auto samples = api.store.LoadSamples(record.id, 0, kIndexMax);
  if (!samples) return samples.error();
  core::DiagnoseOptions options;
  options.period_s = record.period_s;
  options.values = core::ValuePrior::kNone;
  const core::Diagnosis diagnosis = core::DiagnoseRecord(samples.value(), options);
  json::object object = ToJson(diagnosis);
  object["samples"] = samples.value().size();
  object["period_s"] = record.period_s;
  std::string text = json::serialize(object);
  const core::Status kept =
      api.store.ReplaceDiagnosis(record.id, text, std::string(core::Name(diagnosis.verdict.kind)));
  if (!kept.ok()) return kept.error();
  return text;
}

}  // namespace

core::Result<HttpResponse> GetFrames(ApiContext& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {"from"});
  if (!query.ok()) return query.error();
  auto from = QueryInteger(request.http, "from", 0, 0, kIndexMax);
  if (!from) return from.error();
  // The estimators need what came before: the replay starts at 0, the answer at `from`.
  auto recording = Load(api, request, 0, kIndexMax);
  if (!recording) return recording.error();
  HttpResponse response;
  response.content_type = "application/octet-stream";
  std::vector<StreamRow> rows;
  std::int64_t first = 0;
  double t_s = 0.0;
  const auto flush = [&] {
    if (!rows.empty()) AppendReviewFrame(response.body, rows, first, t_s);
    rows.clear();
  };
  ReplayFrames(
      recording.value().samples, recording.value().record.period_s, [&](const core::Frame& frame) {
        if (frame.sample.index < from.value()) return;
        const auto next = first + static_cast<std::int64_t>(rows.size());
        if (frame.sample.index != next || rows.size() == kRowsPerReviewFrame) flush();
        if (rows.empty()) first = frame.sample.index;
        rows.push_back(MakeRow(frame));
        t_s = frame.sample.t_s;
      });
  flush();
  return response;
}

core::Result<HttpResponse> GetSamples(ApiContext& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {"from", "to"});
  if (!query.ok()) return query.error();
  auto from = QueryInteger(request.http, "from", 0, 0, kIndexMax);
  if (!from) return from.error();
  auto to = QueryInteger(request.http, "to", kIndexMax, 0, kIndexMax);
  if (!to) return to.error();
  auto recording = Load(api, request, from.value(), to.value());
  if (!recording) return recording.error();
  std::string out = "{\"period_s\":";
  AppendNumber(out, recording.value().record.period_s);
  out.append(SampleColumns(recording.value().samples)).append("}");
  return JsonText(std::move(out));
}

core::Result<HttpResponse> GetEstimates(ApiContext& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {"estimator"});
  if (!query.ok()) return query.error();
  const std::string name = request.http.Query("estimator").value_or("swa_100");
  const auto shape = std::find_if(core::kEstimatorShapes.begin(),
                                  core::kEstimatorShapes.end(),
                                  [&](const auto& s) { return s.name == name; });
  if (shape == core::kEstimatorShapes.end()) {
    std::string list;
    for (const auto& known : core::kEstimatorShapes) {
      list.append(list.empty() ? "" : ", ").append(known.name);
    }
    return core::Error{
        core::ErrorCode::kInvalid, "Unknown estimator; known: " + list + ".", "estimator"};
  }
  const auto which = static_cast<std::size_t>(shape - core::kEstimatorShapes.begin());
  auto recording = Load(api, request, 0, kIndexMax);
  if (!recording) return recording.error();
  struct Line {
    std::int64_t index;
    core::Estimate<3> estimate;
  };
  std::vector<Line> lines;
  ReplayFrames(
      recording.value().samples, recording.value().record.period_s, [&](const core::Frame& frame) {
        lines.push_back({frame.sample.index, frame.estimates[which]});
      });
  const char* suffix = shape->integral_samples == 0 ? "d" : "";
  std::string out = "{\"estimator\":\"" + name + "\",\"period_s\":";
  AppendNumber(out, recording.value().record.period_s);
  AppendColumn(out, "index", lines, [](const Line& l) { return static_cast<double>(l.index); });
  constexpr std::array<std::string_view, 3> kParameters = {"b0", "b1", "a1"};
  for (std::size_t p = 0; p < kParameters.size(); ++p) {
    const std::string parameter = std::string(kParameters[p]) + suffix;
    const auto known = [](const Line& line, double value) {
      return line.estimate.status == core::EstimateStatus::kInvalid ? core::kAbsent : value;
    };
    AppendColumn(
        out, parameter, lines, [&](const Line& l) { return known(l, l.estimate.theta[p]); });
    AppendColumn(out, "sigma_" + parameter, lines, [&](const Line& l) {
      return known(l, l.estimate.sigma[p]);
    });
  }
  AppendColumn(out, "condition", lines, [](const Line& l) { return l.estimate.condition; });
  out.append(",\"status\":[");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    out.append(i > 0 ? ",\"" : "\"").append(core::Name(lines[i].estimate.status)).append("\"");
  }
  out.append("]");
  AppendColumn(
      out, "age", lines, [](const Line& l) { return static_cast<double>(l.estimate.age_samples); });
  return JsonText(out.append("}"));
}

core::Result<HttpResponse> GetDiagnosis(ApiContext& api, const ApiRequest& request) {
  auto record = AuthorizedRun(api, request, Operation::kReadRun);
  if (!record) return record.error();
  if (record.value().state == RunState::kRunning) {
    if (const auto live = api.runs.Find(record.value().id)) return JsonText(live->diagnosis_json);
  }
  if (!record.value().diagnosis_json.empty()) return JsonText(record.value().diagnosis_json);
  auto made = DiagnoseStored(api, record.value());
  if (!made) return made.error();
  return JsonText(std::move(made).value());
}

core::Result<HttpResponse> ExportCsv(ApiContext& api, const ApiRequest& request) {
  auto recording = Load(api, request, 0, kIndexMax);
  if (!recording) return recording.error();
  const RunRecord& record = recording.value().record;
  auto events = api.store.LoadEvents(record.id);
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

core::Result<HttpResponse> ExportJson(ApiContext& api, const ApiRequest& request) {
  auto recording = Load(api, request, 0, kIndexMax);
  if (!recording) return recording.error();
  const RunRecord& record = recording.value().record;
  auto events = api.store.LoadEvents(record.id);
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

core::Result<HttpResponse> ExportMat(ApiContext& api, const ApiRequest& request) {
  auto recording = Load(api, request, 0, kIndexMax);
  if (!recording) return recording.error();
  const RunRecord& record = recording.value().record;
  std::vector<core::Frame> frames;
  frames.reserve(recording.value().samples.size());
  ReplayFrames(recording.value().samples, record.period_s, [&](const core::Frame& frame) {
    frames.push_back(frame);
  });
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
