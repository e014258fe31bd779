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

template <typename Items>
json::array Texts(const Items& items) {
  json::array out;
  for (const auto& item : items) out.push_back(json::value(item));
  return out;
}

/// On which the recording was measured.
core::Result<const core::Bench*> BenchOfUpload(RunApi& api, const HttpRequest& request) {
  const auto name = request.Query("bench");
  if (!name) return &api.benches.usual();
  auto bench = api.benches.Find(*name);
  if (!bench) return refusal::In(bench.error(), "bench");
  return bench;
}

/// As usual on the bench, but for what the query names: the healthy stretch, or another recording
/// whose calibration is taken.
core::Result<core::DiagnosisOptions> OptionsOf(RunApi& api,
                                               const ApiRequest& request,
                                               const core::Bench& bench,
                                               double period_s,
                                               double first_s) {
  core::DiagnosisOptions options = core::OptionsOf(bench, period_s);
  core::CountFrom(first_s, options);
  const auto from_s = QueryNumber(
      request.http, "healthy_from_s", options.healthy_from_s, -kSecondsMax, kSecondsMax);
  if (!from_s) return from_s.error();
  const auto to_s =
      QueryNumber(request.http, "healthy_to_s", options.healthy_to_s, -kSecondsMax, kSecondsMax);
  if (!to_s) return to_s.error();
  if (to_s.value() <= from_s.value()) return refusal::StretchBackwards("healthy_to_s");
  options.healthy_from_s = from_s.value();
  options.healthy_to_s = to_s.value();
  if (const auto id = request.http.Query("calibration")) {
    auto calibration = api.recordings.CalibrationOf(request.who, *id, bench);
    if (!calibration) return calibration.error();
    options.calibration = std::move(calibration).value();
    const core::Status fits = CheckPeriod(options.calibration, period_s);
    if (!fits.ok()) return fits.error();
  }
  return options;
}

/// Is the body compressed? Its first bytes say so too, whatever its type.
bool IsGzip(const HttpRequest& request) {
  return request.Header("Content-Type").starts_with("application/gzip") ||
         request.body.starts_with("\x1f\x8b");
}

}  // namespace

core::Result<HttpResponse> UploadRecording(RunApi& api, const ApiRequest& request) {
  const core::Status query =
      OnlyQuery(request.http, {"name", "bench", "healthy_from_s", "healthy_to_s", "calibration"});
  if (!query.ok()) return query.error();
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
    const std::string most = std::to_string(kNameBytesMax);
    return core::Error{
        core::ErrorCode::kInvalid,
        "'name' must be a text of at most " + most + " bytes without control characters.",
        "name",
        "text_refused",
        {{"member", "name"}, {"most", most}}};
  }
  const auto bench = BenchOfUpload(api, request.http);
  if (!bench) return bench.error();
  const core::Status may = api.recordings.MayBring(request.who);
  if (!may.ok()) return may.error();
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
  auto parsed = ParseCsv(gzip ? std::string_view(unpacked) : request.http.body, name, limits);
  if (!parsed) return parsed.error();
  CsvRecord csv = std::move(parsed).value();
  if (name != asked) {
    csv.notes.push_back("the name was cut to " + std::to_string(kNameBytesMax) + " bytes");
  }

  auto notes = NotesOnRecord(csv.channels, csv.samples, *bench.value(), name);
  if (!notes) return notes.error();
  std::ranges::move(notes.value(), std::back_inserter(csv.notes));
  if (std::string note = NoteOnOtherBench(name, BenchInComments(csv.comments), *bench.value());
      !note.empty()) {
    csv.notes.push_back(std::move(note));
  }
  auto options = OptionsOf(api, request, *bench.value(), csv.period_s, csv.samples.front().t_s);
  if (!options) return options.error();
  const std::size_t size = csv.samples.size();
  const core::Status room = api.quota.MakeRoom(request.who, static_cast<std::int64_t>(size));
  if (!room.ok()) return room.error();
  const auto kept = api.recordings.Keep({name,
                                         request.who.owner_key(),
                                         std::move(options).value(),
                                         csv.channels,
                                         std::move(csv.samples)});
  if (!kept) return kept.error();
  const RunRecord& record = kept.value().record;
  const std::vector<std::int64_t>& copy_of = kept.value().copy_of;
  for (const std::int64_t trial : copy_of) {
    NoteOnRun(api,
              {request.who, "bring_sealed", "run:" + record.id, "trial " + std::to_string(trial)});
  }
  HttpResponse response = JsonResponse(
      json::object{{"id", record.id},
                   {"name", record.name},
                   {"bench", record.bench},
                   {"samples", size},
                   {"period_s", csv.period_s},
                   {"channels", Texts(csv.channels)},
                   {"notes", Texts(csv.notes)},
                   {"missing_samples", csv.missing_samples},
                   {"verdict", record.verdict},
                   {"reason", copy_of.empty() ? kept.value().verdict.reason : kCopyIsSealed},
                   {"sealed", !copy_of.empty()},
                   {"created_at", Iso8601(record.created_at)}},
      201);
  response.headers.emplace_back("Location", "/api/v1/runs/" + record.id);
  return response;
}

core::Result<HttpResponse> ListRecordings(RunApi& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {"cursor", "limit"});
  if (!query.ok()) return query.error();
  auto limit = PageLimit(request.http);
  if (!limit) return limit.error();
  RunFilter filter;
  filter.source = "upload";
  const bool all = Authorize(request.who, Operation::kReadRun, Ownership::kForeign).ok();
  if (!all) filter.owner = request.who.owner_key();
  auto page = api.store.List(request.http.Query("cursor").value_or(""), limit.value(), filter);
  if (!page) return page.error();
  OpenDue(api, page.value().items);
  json::array items;
  for (const RunRecord& record : page.value().items) {
    items.push_back(json::object{{"id", record.id},
                                 {"name", record.name},
                                 {"bench", record.bench},
                                 {"samples", record.samples},
                                 {"period_s", record.period_s},
                                 {"created_at", Iso8601(record.created_at)},
                                 {"verdict", record.verdict},
                                 {"sealed", IsSealed(record.plan_json)}});
  }
  json::object out{{"items", std::move(items)}, {"next_cursor", nullptr}};
  if (!page.value().next_cursor.empty()) out["next_cursor"] = page.value().next_cursor;
  return JsonResponse(out);
}

}  // namespace faultlab::server
