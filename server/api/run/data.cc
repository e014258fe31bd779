#include <algorithm>
#include <array>
#include <cstring>

#include "core/diagnosis/diagnose_record.h"
#include "server/api/run/columns.h"
#include "server/api/run/handlers.h"
#include "server/stream/frame_codec.h"

namespace faultlab::server {
namespace {

constexpr std::size_t kRowsPerReviewFrame = 100;

void AppendReviewFrame(Spool& out,
                       std::span<const StreamRow> rows,
                       std::int64_t first,
                       double t_s) {
  const std::string frame = EncodeFrameMessage(rows, first, t_s);
  const auto size = static_cast<std::uint32_t>(frame.size());
  std::array<char, sizeof size> prefix;
  std::memcpy(prefix.data(), &size, sizeof size);
  out.Append({prefix.data(), prefix.size()});
  out.Append(frame);
}

core::Result<HttpResponse> GetFrames(Api& api, const ApiRequest& request) {
  TRY(auto from, QueryInteger(request.http, "from", 0, 0, kSampleIndexMax));
  // The estimators need what came before: the replay starts at 0, the answer at `from`.
  TRY(auto recording, api.recordings.Load(request.run));
  auto out = api.MakeSpool();
  std::vector<StreamRow> rows;
  std::int64_t first = 0;
  double t_s = 0.0;
  const auto flush = [&] {
    if (!rows.empty()) AppendReviewFrame(*out, rows, first, t_s);
    rows.clear();
  };
  core::ReplayEstimates(recording.samples, recording.options, [&](const core::Frame& frame) {
    if (frame.sample.index < from) return;
    const auto next = first + static_cast<std::int64_t>(rows.size());
    if (frame.sample.index != next || rows.size() == kRowsPerReviewFrame) flush();
    if (rows.empty()) first = frame.sample.index;
    rows.push_back(MakeRow(frame));
    t_s = frame.sample.t_s;
  });
  flush();
  return Spooled(std::move(out), "application/octet-stream");
}

core::Result<HttpResponse> GetSamples(Api& api, const ApiRequest& request) {
  TRY(auto from, QueryInteger(request.http, "from", 0, 0, kSampleIndexMax));
  TRY(auto to, QueryInteger(request.http, "to", kSampleIndexMax, 0, kSampleIndexMax));
  TRY(auto recording, api.recordings.Load(request.run, from, to));
  auto out = api.MakeSpool();
  std::string head = "{\"period_s\":";
  AppendNumber(head, recording.record.period_s);
  out->Append(head);
  AppendSampleColumns(*out, recording.samples);
  out->Append("}");
  return Spooled(std::move(out), "application/json");
}

core::Result<HttpResponse> GetEstimates(Api& api, const ApiRequest& request) {
  TRY(const auto estimator, EstimatorIn(request.http, core::EstimatorId::kSwa100));
  const auto which = static_cast<std::size_t>(estimator);
  const core::EstimatorShape& shape = core::kEstimatorShapes[which];
  TRY(auto recording, api.recordings.Load(request.run));
  struct Line {
    std::int64_t index;
    core::Estimate<3> estimate;
  };
  std::vector<Line> lines;
  core::ReplayEstimates(recording.samples, recording.options, [&](const core::Frame& frame) {
    lines.push_back({frame.sample.index, core::Shown(frame.estimates[which])});
  });
  const char* suffix = shape.integral_samples == 0 ? "d" : "";
  auto out = api.MakeSpool();
  std::string head = "{\"estimator\":\"" + std::string(shape.name) + "\",\"period_s\":";
  AppendNumber(head, recording.record.period_s);
  out->Append(head);
  AppendColumn(*out, "index", lines, [](const Line& l) { return static_cast<double>(l.index); });
  constexpr std::array<std::string_view, 3> kParameters = {"b0", "b1", "a1"};
  for (std::size_t p = 0; p < kParameters.size(); ++p) {
    const std::string parameter = std::string(kParameters[p]) + suffix;
    AppendColumn(*out, parameter, lines, [p](const Line& l) { return l.estimate.theta[p]; });
    AppendColumn(
        *out, "sigma_" + parameter, lines, [p](const Line& l) { return l.estimate.sigma[p]; });
  }
  AppendColumn(*out, "condition", lines, [](const Line& l) { return l.estimate.condition; });
  out->Append(",\"status\":[");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    out->Append(i > 0 ? ",\"" : "\"");
    out->Append(core::Name(lines[i].estimate.status));
    out->Append("\"");
  }
  out->Append("]");
  AppendColumn(*out, "age", lines, [](const Line& l) {
    return static_cast<double>(l.estimate.age_samples);
  });
  out->Append("}");
  return Spooled(std::move(out), "application/json");
}

core::Result<HttpResponse> GetDiagnosis(Api& api, const ApiRequest& request) {
  TRY(auto text, api.recordings.DiagnosisText(request.run));
  return JsonText(std::move(text));
}

}  // namespace

core::Result<core::EstimatorId> EstimatorIn(const HttpRequest& request, core::EstimatorId usual) {
  const auto name = request.Query("estimator");
  if (!name) return usual;
  const auto shape = std::ranges::find(core::kEstimatorShapes, *name, &core::EstimatorShape::name);
  if (shape != core::kEstimatorShapes.end()) {
    return static_cast<core::EstimatorId>(shape - core::kEstimatorShapes.begin());
  }
  std::string known;
  for (const auto& each : core::kEstimatorShapes) {
    known.append(known.empty() ? "" : ", ").append(each.name);
  }
  return core::Refuse("no_estimator", "estimator", {{"known", known}});
}

std::span<const ApiRoute> DataRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kGet, "runs/{id}/frames", kReadRun, kRun, GetFrames, kNoBody, kTransfer}.Takes(
          "from"),
      ApiRoute{kGet, "runs/{id}/samples", kReadRun, kRun, GetSamples, kNoBody, kTransfer}.Takes(
          "from to"),
      ApiRoute{kGet, "runs/{id}/estimates", kReadRun, kRun, GetEstimates, kNoBody, kTransfer}.Takes(
          "estimator"),
      {kGet, "runs/{id}/diagnosis", kReadRun, kRun, GetDiagnosis, kNoBody, kQuick, kRunsMember},
  });
  return kRoutes;
}

}  // namespace faultlab::server
