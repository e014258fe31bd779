#include "server/api/api.h"

#include <algorithm>
#include <array>
#include <boost/json.hpp>
#include <charconv>
#include <utility>

#include "server/api/lab/handlers.h"
#include "server/api/whereabouts.h"
#include "server/net/websocket.h"

namespace faultlab::server {
namespace {

constexpr int kPageDefault = 50;
constexpr int kPageMax = 200;

constexpr std::size_t kLargeBytes = 1 << 20;

bool AsksWho(const ApiRoute& route) {
  return route.guard != Guard::kOpen && route.guard != Guard::kAnybody;
}

/// Who sends the request, if they may use the route at all.
core::Result<Principal> CallerOf(ApiContext& api, const ApiRoute& route, const HttpRequest& http) {
  if (!AsksWho(route)) return Principal{};
  const RequestCredentials credentials{
      http.Header("Cookie"),
      http.Header("Authorization"),
      http.Header(kCsrfHeaderName),
      http.Header("Origin"),
      http.Header("Host"),
      http.remote_address,
      http.method != HttpMethod::kGet && http.method != HttpMethod::kHead};
  auto who = api.authenticator.Authenticate(credentials, api.clock.Wall());
  if (!who || route.guard != Guard::kRole) return who;
  const core::Status allowed = Authorize(who.value(), route.operation, Ownership::kNone);
  if (!allowed.ok()) return allowed.error();
  return who;
}

/// All guests are one owner, but each address has transfers of its own.
std::string TransferKey(const Principal& who, const HttpRequest& http) {
  return who.signed_in() ? who.owner_key() : "guest " + std::string(http.remote_address);
}

bool IsLarge(const ApiRoute& route) {
  return route.answer == AnswerSize::kLarge || route.body.bytes_max > kLargeBytes;
}

Admission Admit(ApiContext& api, const ApiRoute& route, const HttpRequest& http) {
  auto who = CallerOf(api, route, http);
  if (!who) return {.refusal = ProblemOf(who.error())};
  if (!IsLarge(route)) return {};
  const std::string key = TransferKey(who.value(), http);
  if (auto slot = api.transfers.Take(key)) return {.held = std::move(slot)};
  constexpr int kSeconds = 2;
  HttpResponse refusal =
      TryAgain(429,
               "Two large downloads or uploads of yours are on their way; wait until one ends.",
               kSeconds);
  auto place = api.transfers.Wait(key);
  const bool waits = place != nullptr;
  return {.refusal = std::move(refusal), .not_yet = waits, .held = std::move(place)};
}

RouteAnswer Serve(ApiContext& api, const ApiRoute& route, const HttpRequest& http) {
  auto known = CallerOf(api, route, http);
  if (!known) return ProblemOf(known.error());
  const Principal& who = known.value();
  if (route.body.is_json && !http.body.empty() &&
      !http.Header("Content-Type").starts_with("application/json")) {
    return Problem(415,
                   "unsupported_media_type",
                   "Unsupported media type",
                   "Send the body as Content-Type: application/json.");
  }
  if (auto elsewhere = AnsweredElsewhere(api, route, http)) {
    if (!http.from_peer) return std::move(*elsewhere);
    // The servers' views differ for a moment: nobody passes on what was passed on.
    return TryAgain(503, "The rig or run of this request is moving to another server.", 1);
  }
  core::Result<HttpResponse> answer = route.handler(api, {http, who});
  if (!answer.ok()) return ProblemOf(answer.error());
  if (route.lives_at != LivesAt::kEveryMember || http.from_peer) return std::move(answer).value();
  return JoinedWithOthers(api, std::move(answer).value());
}

}  // namespace

void AddRoutes(Router& router, ApiContext& api, const std::vector<ApiRoute>& routes) {
  for (const ApiRoute& route : routes) {
    Route entry{route.method,
                std::string(route.pattern),
                route.guard == Guard::kOpen ? RunsOn::kInline : RunsOn::kPool,
                route.body.bytes_max,
                [&api, route](const HttpRequest& http) { return Serve(api, route, http); }};
    if (AsksWho(route)) {
      entry.admit = [&api, route](const HttpRequest& http) { return Admit(api, route, http); };
      entry.always_admit = IsLarge(route);
    }
    router.Add(std::move(entry));
  }
}

UpgradeDecision DecideUpgrade(ApiContext& api, const HttpRequest& request) {
  if (request.path != "/ws") {
    return Problem(404, "not_found", "Not found", "WebSockets are at /ws.");
  }
  const auto code = request.Query("code");
  if (code && !request.from_peer) {
    if (auto member = MemberOfCode(api, *code)) return std::move(*member);
  }
  auto grant = code ? api.tokens.Redeem(*code) : std::nullopt;
  if (!grant) {
    return Problem(403,
                   "bad_code",
                   "Code not accepted",
                   "The code is unknown, used or older than 30 s; ask for a new stream token.",
                   "code");
  }
  return [&api, grant = std::move(*grant)](UpgradedSocket socket) {
    api.hub.Adopt(std::move(socket), grant.run, grant.can_command);
  };
}

HttpResponse JsonResponse(const boost::json::value& value, int status) {
  HttpResponse response;
  response.status = status;
  response.body = boost::json::serialize(value);
  return response;
}

int HttpStatus(core::ErrorCode code) {
  switch (code) {
    case core::ErrorCode::kInvalid:
      return 400;
    case core::ErrorCode::kNotFound:
      return 404;
    case core::ErrorCode::kConflict:
    case core::ErrorCode::kStale:
      return 409;
    case core::ErrorCode::kUnauthorized:
      return 401;
    case core::ErrorCode::kForbidden:
      return 403;
    case core::ErrorCode::kBusy:
      return 503;
    case core::ErrorCode::kTooLarge:
      return 413;
    case core::ErrorCode::kUnavailable:
      return 503;
  }
  return 500;
}

HttpResponse ProblemOf(const core::Error& error) {
  const int status = HttpStatus(error.code);
  HttpResponse response =
      Problem(status, Name(error.code), ReasonPhrase(status), error.message, error.field);
  if (status == 503) response.headers.emplace_back("Retry-After", "2");
  if (status == 401) response.headers.emplace_back("WWW-Authenticate", "Bearer");
  return response;
}

HttpResponse Download(std::string bytes, std::string_view content_type, std::string file_name) {
  for (char& c : file_name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '_' || c == '.';
    if (!plain) c = '_';
  }
  HttpResponse response;
  response.content_type = content_type;
  response.body = std::move(bytes);
  response.headers.emplace_back("Content-Disposition",
                                "attachment; filename=\"" + file_name + "\"");
  return response;
}

core::Result<std::int64_t> QueryInteger(const HttpRequest& request,
                                        std::string_view name,
                                        std::int64_t fallback,
                                        std::int64_t lo,
                                        std::int64_t hi) {
  const auto text = request.Query(name);
  if (!text) return fallback;
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error == std::errc() && end == text->data() + text->size() && value >= lo && value <= hi) {
    return value;
  }
  return core::Error{core::ErrorCode::kInvalid,
                     "'" + std::string(name) + "' must be a whole number from " +
                         std::to_string(lo) + " to " + std::to_string(hi) + ".",
                     std::string(name)};
}

core::Result<int> PageLimit(const HttpRequest& request) {
  auto limit = QueryInteger(request, "limit", kPageDefault, 1, kPageMax);
  if (!limit) return limit.error();
  return static_cast<int>(limit.value());
}

core::Status OnlyQuery(const HttpRequest& request, std::initializer_list<std::string_view> known) {
  for (const auto& [name, value] : request.QueryAll()) {
    if (!websocket::IsValidUtf8(name) || !websocket::IsValidUtf8(value)) {
      return core::Error{core::ErrorCode::kInvalid, "A query parameter is not UTF-8.", ""};
    }
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    constexpr std::size_t kShownMax = 64;
    const std::string shown = name.size() > kShownMax ? "(a long name)" : name;
    return core::Error{
        core::ErrorCode::kInvalid, "Unknown query parameter '" + shown + "'.", shown};
  }
  return core::Done{};
}

Ownership OwnershipOf(const Principal& who, std::string_view owner_key) {
  return owner_key == who.owner_key() ? Ownership::kOwn : Ownership::kForeign;
}

core::Result<RunRecord> AuthorizedRun(ApiContext& api,
                                      const ApiRequest& request,
                                      Operation operation) {
  auto record = api.store.Get(request.http.PathParameter("id"));
  if (!record) return record.error();
  const auto whose = RelationTo(api, request.who, record.value().owner);
  if (!whose) return whose.error();
  const core::Status allowed = Authorize(request.who, operation, whose.value());
  if (!allowed.ok()) return allowed.error();
  return record;
}

}  // namespace faultlab::server
