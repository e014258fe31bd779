#include <algorithm>
#include <boost/json.hpp>
#include <iterator>

#include "core/types/utf8.h"
#include "server/api/run/handlers.h"
#include "server/csv/bench_comment.h"
#include "server/csv/csv_record.h"
#include "server/csv/file_io.h"
#include "server/diagnosis_json/calibration_json.h"
#include "server/diagnosis_json/channels_text.h"
#include "server/experiment/plan_json.h"
#include "server/json/json_reader.h"
#include "server/run/refusals.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr const char* kCopyIsSealed =
    "This is a record, or part of one, of a blind exercise that is still open. The lab keeps it, "
    "and "
    "diagnoses it when the exercise is released; its teachers see who brought it and when.";
constexpr std::size_t kRowsMax = 1'000'000;
/// Of the text, after decompression: a run of 600 s at 1 kHz is 54 MB.
constexpr std::size_t kTextBytesMax = 80 << 20;
/// Of a record that this server takes.
constexpr double kSecondsMax = 1e9;

/// On which the recording was measured.
core::Result<const core::Bench*> BenchOfUpload(Api& api, const HttpRequest& request) {
  const auto name = request.Query("bench");
  if (!name) return &api.benches.usual();
  auto bench = api.benches.Find(*name);
  if (!bench) return refusal::In(bench.error(), "bench");
  return bench;
}

/// As usual on the bench, but for what the query names: the healthy stretch, or another recording
/// whose calibration is taken.
core::Result<core::DiagnosisOptions> OptionsOf(Api& api,
                                               const ApiRequest& request,
                                               const core::Bench& bench,
                                               double period_s,
                                               double first_s) {
  core::DiagnosisOptions options = core::OptionsOf(bench, period_s);
  core::CountFrom(first_s, options);
  TRY(const auto from_s,
      QueryNumber(
          request.http, "healthy_from_s", options.healthy_from_s, -kSecondsMax, kSecondsMax));
  TRY(const auto to_s,
      QueryNumber(request.http, "healthy_to_s", options.healthy_to_s, -kSecondsMax, kSecondsMax));
  if (to_s <= from_s) return core::Refuse("stretch_backwards", "healthy_to_s");
  options.healthy_from_s = from_s;
  options.healthy_to_s = to_s;
  if (const auto id = request.http.Query("calibration")) {
    TRY(options.calibration, api.recordings.CalibrationOf(request.who, *id, bench));
    TRY_DONE(CheckPeriod(options.calibration, period_s));
  }
  return options;
}

/// Is the body compressed? Its first bytes say so too, whatever its type.
bool IsGzip(const HttpRequest& request) {
  return request.Header("Content-Type").starts_with("application/gzip") ||
         request.body.starts_with("\x1f\x8b");
}

core::Result<HttpResponse> UploadRecording(Api& api, const ApiRequest& request) {
  const bool gzip = IsGzip(request.http);
  if (!gzip && !request.http.Header("Content-Type").starts_with("text/csv")) {
    return Problem(415,
                   "unsupported_media_type",
                   "Unsupported media type",
                   "Send the recording as Content-Type: text/csv, or application/gzip.");
  }
  const std::string asked = request.http.Query("name").value_or("upload");
  const std::string name(core::CutUtf8(asked, kNameBytesMax));
  if (HasControlCharacter(name)) {
    return core::Refuse("text_refused", "name", {{"member", "name"}, {"most", kNameBytesMax}});
  }
  TRY(const auto bench, BenchOfUpload(api, request.http));
  TRY_DONE(api.recordings.MayBring(request.who));
  LongTurn& long_turn = api.recordings.long_turn();
  auto turn = long_turn.ForText(request.http.body.size());
  if (!turn) return turn.error();
  std::string unpacked;
  if (gzip) {
    auto text = Gunzip(request.http.body, name, long_turn.limit().text_bytes);
    if (!text && text.error().code == core::ErrorCode::kTooLarge) {
      if (turn.value() == nullptr) turn = long_turn.ForText(kTextBytesMax);
      if (!turn) return turn.error();
      text = Gunzip(request.http.body, name, kTextBytesMax);
    }
    if (!text) return text.error();
    unpacked = std::move(text).value();
  }
  CsvLimits limits;
  limits.bytes_max = kTextBytesMax;
  limits.rows_max = kRowsMax;
  TRY(auto csv, ParseCsv(gzip ? std::string_view(unpacked) : request.http.body, name, limits));
  if (name != asked) {
    csv.notes.push_back("the name was cut to " + std::to_string(kNameBytesMax) + " bytes");
  }

  TRY(auto notes, NotesOnRecord(csv.channels, csv.samples, *bench, name));
  std::ranges::move(notes, std::back_inserter(csv.notes));
  if (std::string note = NoteOnOtherBench(name, BenchInComments(csv.comments), *bench);
      !note.empty()) {
    csv.notes.push_back(std::move(note));
  }
  TRY(auto options, OptionsOf(api, request, *bench, csv.period_s, csv.samples.front().t_s));
  const std::size_t size = csv.samples.size();
  TRY_DONE(api.quota.MakeRoom(request.who, static_cast<std::int64_t>(size)));
  TRY(const auto kept,
      api.recordings.Keep({name,
                           request.who.owner_key(),
                           std::move(options),
                           csv.channels,
                           std::move(csv.samples)}));
  const RunRecord& record = kept.record;
  const std::vector<std::int64_t>& copy_of = kept.copy_of;
  for (const std::int64_t trial : copy_of) {
    NoteOnRun(api,
              {request.who, "bring_sealed", "run:" + record.id, "trial " + std::to_string(trial)});
  }
  HttpResponse response =
      JsonResponse(json::object{{"id", record.id},
                                {"name", record.name},
                                {"bench", record.bench},
                                {"samples", size},
                                {"period_s", csv.period_s},
                                {"channels", ListOf(csv.channels)},
                                {"notes", ListOf(csv.notes)},
                                {"missing_samples", csv.missing_samples},
                                {"verdict", record.verdict},
                                {"reason", copy_of.empty() ? kept.verdict.reason : kCopyIsSealed},
                                {"sealed", !copy_of.empty()},
                                {"created_at", Iso8601(record.created_at)}},
                   201);
  response.headers.emplace_back("Location", "/api/v1/runs/" + record.id);
  return response;
}

core::Result<HttpResponse> ListRecordings(Api& api, const ApiRequest& request) {
  TRY(auto limit, PageLimit(request.http));
  RunFilter filter;
  filter.source = "upload";
  const bool all = Authorize(request.who, Operation::kReadRun, Ownership::kForeign).ok();
  if (!all) filter.owner = request.who.owner_key();
  TRY(auto page, api.store.List(request.http.Query("cursor").value_or(""), limit, filter));
  OpenDue(api, page.items);
  const auto to_json = [](const RunRecord& record) {
    return json::object{{"id", record.id},
                        {"name", record.name},
                        {"bench", record.bench},
                        {"samples", record.samples},
                        {"period_s", record.period_s},
                        {"created_at", Iso8601(record.created_at)},
                        {"verdict", record.verdict},
                        {"sealed", IsSealed(record.plan_json)}};
  };
  return ListAnswer(ListOf(page.items, to_json), page.next_cursor);
}

}  // namespace

std::span<const ApiRoute> UploadsRoutes() {
  using namespace routing;
  static constexpr auto kRoutes = std::to_array<ApiRoute>({
      ApiRoute{kPost, "recordings", kUploadRecording, kRole, UploadRecording, kUpload, kTransfer}
          .Takes("name bench healthy_from_s healthy_to_s calibration"),
      ApiRoute{kGet, "recordings", kReadRun, kObject, ListRecordings}.Takes("cursor limit"),
  });
  return kRoutes;
}

}  // namespace faultlab::server
