#include <boost/json.hpp>

#include "server/api/run/handlers.h"
#include "server/csv/csv_record.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

constexpr std::size_t kRowsMax = 1'000'000;

template <typename Items>
json::array Texts(const Items& items) {
  json::array out;
  for (const auto& item : items) out.push_back(json::value(item));
  return out;
}

}  // namespace

core::Result<HttpResponse> UploadRecording(RunApi& api, const ApiRequest& request) {
  const core::Status query = OnlyQuery(request.http, {"name"});
  if (!query.ok()) return query.error();
  if (!request.http.Header("Content-Type").starts_with("text/csv")) {
    return Problem(415,
                   "unsupported_media_type",
                   "Unsupported media type",
                   "Send the recording as Content-Type: text/csv.");
  }
  const std::string name = CutText(request.http.Query("name").value_or("upload"), kNameBytesMax);
  CsvLimits limits;
  limits.bytes_max = kUpload.bytes_max;
  limits.rows_max = kRowsMax;
  auto parsed = ParseCsv(request.http.body, name, limits);
  if (!parsed) return parsed.error();
  CsvRecord csv = std::move(parsed).value();

  const std::size_t size = csv.samples.size();
  const core::Status room = api.quota.MakeRoom(request.who, static_cast<std::int64_t>(size));
  if (!room.ok()) return room.error();
  const auto kept = api.recordings.Keep(
      {name, request.who.owner_key(), csv.channels, csv.period_s, std::move(csv.samples)});
  if (!kept) return kept.error();
  const RunRecord& record = kept.value();
  HttpResponse response = JsonResponse(json::object{{"id", record.id},
                                                    {"name", record.name},
                                                    {"samples", size},
                                                    {"period_s", csv.period_s},
                                                    {"channels", Texts(csv.channels)},
                                                    {"notes", Texts(csv.notes)},
                                                    {"missing_samples", csv.missing_samples},
                                                    {"verdict", record.verdict},
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
