#include <boost/json.hpp>

#include "core/diagnosis/diagnosis.h"
#include "server/api/handlers.h"
#include "server/csv/csv_record.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/storage/ids.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kSamplesPerChunk = 1000;
constexpr std::size_t kRowsMax = 1'000'000;
constexpr std::size_t kNameBytesMax = 200;

core::Status StoreSamples(ApiContext& api,
                          const std::string& id,
                          std::span<const core::Sample> samples) {
  for (std::size_t at = 0; at < samples.size(); at += kSamplesPerChunk) {
    const auto chunk = samples.subspan(at, std::min(kSamplesPerChunk, samples.size() - at));
    const core::Status stored = api.store.AppendChunk(id, chunk.front().index, chunk);
    if (!stored.ok()) return stored;
  }
  return core::Done{};
}

template <typename Items>
json::array Texts(const Items& items) {
  json::array out;
  for (const auto& item : items) out.push_back(json::value(item));
  return out;
}

}  // namespace

core::Result<HttpResponse> UploadRecording(ApiContext& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {"name"});
  if (!query.ok()) return query.error();
  if (!request.http.Header("Content-Type").starts_with("text/csv")) {
    return Problem(415,
                   "unsupported_media_type",
                   "Unsupported media type",
                   "Send the recording as Content-Type: text/csv.");
  }
  const std::string name = request.http.Query("name").value_or("upload").substr(0, kNameBytesMax);
  CsvLimits limits;
  limits.bytes_max = kUpload.bytes_max;
  limits.rows_max = kRowsMax;
  auto parsed = ParseCsv(request.http.body, name, limits);
  if (!parsed) return parsed.error();
  const CsvRecord& csv = parsed.value();

  core::DiagnoseOptions options;
  options.period_s = csv.period_s;
  options.values = core::ValuePrior::kNone;
  const core::Diagnosis diagnosis = core::DiagnoseRecord(csv.samples, options);
  json::object diagnosis_object = ToJson(diagnosis);
  diagnosis_object["samples"] = csv.samples.size();
  diagnosis_object["period_s"] = csv.period_s;
  diagnosis_object["channels"] = Texts(csv.channels);

  RunRecord record;
  record.id = NewId("rec");
  record.name = name;
  record.owner = request.who.owner_key();
  record.source = "upload";
  record.period_s = csv.period_s;
  record.created_at = api.clock.Wall();
  core::Status stored = api.store.Begin(record);
  if (stored.ok()) stored = StoreSamples(api, record.id, csv.samples);
  if (stored.ok()) {
    stored = api.store.Finish(record.id,
                              RunState::kFinished,
                              api.clock.Wall(),
                              json::serialize(diagnosis_object),
                              std::string(core::Name(diagnosis.verdict.kind)));
  }
  if (!stored.ok()) return stored.error();
  HttpResponse response = JsonResponse(json::object{{"id", record.id},
                                                    {"name", record.name},
                                                    {"samples", csv.samples.size()},
                                                    {"period_s", csv.period_s},
                                                    {"channels", Texts(csv.channels)},
                                                    {"notes", Texts(csv.notes)},
                                                    {"missing_samples", csv.missing_samples},
                                                    {"verdict", core::Name(diagnosis.verdict.kind)},
                                                    {"created_at", Iso8601(record.created_at)}},
                                       201);
  response.headers.emplace_back("Location", "/api/v1/runs/" + record.id);
  return response;
}

core::Result<HttpResponse> ListRecordings(ApiContext& api, const ApiRequest& request) {
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
  json::array items;
  for (const RunRecord& record : page.value().items) {
    items.push_back(json::object{{"id", record.id},
                                 {"name", record.name},
                                 {"samples", record.samples},
                                 {"period_s", record.period_s},
                                 {"created_at", Iso8601(record.created_at)},
                                 {"verdict", record.verdict}});
  }
  json::object out{{"items", std::move(items)}, {"next_cursor", nullptr}};
  if (!page.value().next_cursor.empty()) out["next_cursor"] = page.value().next_cursor;
  return JsonResponse(out);
}

}  // namespace faultlab::server
