#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/api/iso8601.h"
#include "server/auth/principal.h"
#include "server/json/list_of.h"
#include "server/net/http.h"
#include "server/storage/recording_store.h"
#include "server/stream/viewer_owner.h"

// What handlers read and answer.
namespace faultlab::server {

struct ApiRequest {
  const HttpRequest& http;
  const Principal& who;
  const boost::json::object& body;  ///< empty unless the route takes JSON
  const RunRecord& run;             ///< of the path's {id}, behind Guard::kRun; else empty
};

/// By what right this caller opens a WebSocket.
ViewerOwner ViewerOwnerOf(const Principal& who);
/// ?limit=, 1..200, default 50.
core::Result<int> PageLimit(const HttpRequest& request);
/// One page of a list by id.
struct Page {
  std::int64_t after = 0;  ///< ?cursor=: the last id of the page before
  int limit = 0;

  /// `last` is the id of the last item, looked at when the page is full.
  HttpResponse Answer(boost::json::array items, std::int64_t last) const;
  /// The rows as `each` shows them; `id` is the member that has the id.
  template <typename Row, typename Each>
  HttpResponse Answer(const std::vector<Row>& rows, Each&& each, std::int64_t Row::*id) const {
    return Answer(ListOf(rows, each), rows.empty() ? 0 : rows.back().*id);
  }
};
/// ?cursor= and ?limit=, and no other parameter besides `also`.
core::Result<Page> PageOf(const HttpRequest& request);
/// A whole-number query parameter.
core::Result<std::int64_t> QueryInteger(const HttpRequest& request,
                                        std::string_view name,
                                        std::int64_t fallback,
                                        std::int64_t lo,
                                        std::int64_t hi);
/// A number as a query parameter.
core::Result<double> QueryNumber(
    const HttpRequest& request, std::string_view name, double fallback, double lo, double hi);
/// A query parameter that is one of `words`; none where it is absent.
core::Result<std::optional<std::string>> QueryWord(const HttpRequest& request,
                                                   std::string_view name,
                                                   std::span<const std::string_view> words);
inline core::Result<std::optional<std::string>> QueryWord(
    const HttpRequest& request,
    std::string_view name,
    std::initializer_list<std::string_view> words) {
  return QueryWord(request, name, std::span(words.begin(), words.size()));
}
/// A text to search for: at most 100 characters, for each costs every row that is looked at.
core::Result<std::optional<std::string>> QuerySearch(const HttpRequest& request,
                                                     std::string_view name);
/// Refuses query parameters that are not in `known` ("cursor limit"), by name, any that is given
/// twice, and any that is not UTF-8.
core::Status OnlyQuery(const HttpRequest& request, std::string_view known);
/// The number in the path's {id}; kNotFound when it is none.
core::Result<std::int64_t> PathNumber(const ApiRequest& request, std::string_view name = "id");
/// The version in If-Match: "3". kInvalid with field If-Match when it is missing.
core::Result<std::int64_t> RequiredVersion(const ApiRequest& request);

/// {"items": [..], "next_cursor": ..}; without `next` it is the last page.
HttpResponse ListAnswer(boost::json::array items, const std::string& next = "");
/// With its version as ETag, for If-Match.
HttpResponse Versioned(HttpResponse response, std::int64_t version);
/// A picture to look at; `name` for who saves it.
HttpResponse Png(std::string png, std::string_view name);
/// An instant of the query; nothing if it is not given.
core::Result<std::optional<WallTime>> QueryTime(const HttpRequest& request, std::string_view name);

HttpResponse JsonResponse(const boost::json::value& value, int status = 200);
/// Of something that may still change: `wait` waits until it is settled.
HttpResponse JsonUntilSettled(const boost::json::value& value, bool settled);
/// As Iso8601 writes it.
boost::json::value TimeOrNull(const std::optional<WallTime>& time);
/// Null for an empty text.
boost::json::value TextOrNull(std::string_view text);
/// JSON that was put together as text.
HttpResponse JsonText(std::string text);
HttpResponse NoContent();
/// What was written to a spool; kUnavailable when the disk did not take it.
core::Result<HttpResponse> Spooled(std::unique_ptr<Spool> bytes, std::string_view content_type);
/// The same as a file to save, see ContentDisposition.
core::Result<HttpResponse> Download(std::unique_ptr<Spool> bytes,
                                    std::string_view content_type,
                                    std::string_view file_name);
/// "attachment; filename=..; filename*=..": the name in UTF-8 (RFC 5987), and for old clients with
/// '_' for whatever is not a plain letter. `kind` is "attachment" or "inline".
std::string ContentDisposition(std::string_view kind, std::string_view file_name);
HttpResponse ProblemOf(const core::Error& error);
int HttpStatus(core::ErrorCode code);

}  // namespace faultlab::server
