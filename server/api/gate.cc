#include "server/api/gate.h"

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>
#include <variant>

#include "core/types/utf8.h"
#include "server/address_key.h"
#include "server/api/api.h"
#include "server/auth/secrets.h"
#include "server/json/json_reader.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;

constexpr std::size_t kIdempotencyKeyMax = 200;
constexpr std::int64_t kWaitMaxS = 60;

bool AsksWho(const ApiRoute& route) {
  return route.guard != Guard::kOpen && route.guard != Guard::kAnybody;
}

bool TakesJson(const ApiRoute& route) {
  return route.body.kind == BodyKind::kJson || route.body.kind == BodyKind::kEmpty;
}

RunsOn RunsOnOf(const ApiRoute& route) {
  if (route.guard == Guard::kOpen) return RunsOn::kInline;
  switch (route.cost) {
    case Cost::kQuick:
      return RunsOn::kPool;
    case Cost::kHeavy:
    case Cost::kTransfer:
      return RunsOn::kHeavy;
    case Cost::kPassword:
      return RunsOn::kPassword;
    case Cost::kOutside:
      return RunsOn::kOutside;
  }
  return RunsOn::kPool;
}

core::Result<boost::json::object> BodyOf(const ApiRoute& route, const HttpRequest& http) {
  if (!TakesJson(route)) return boost::json::object{};
  auto body = ParseJsonObject(http.body);
  if (!body || route.body.kind == BodyKind::kJson) return body;
  ObjectReader in(body.value(), "");
  if (auto error = in.Finish()) return *error;
  return body;
}

bool Remembers(const ApiRoute& route, const ApiRequest& request) {
  return request.http.method == HttpMethod::kPost && request.who.signed_in() &&
         route.body.repeat != Repeat::kDoneAgain && !request.http.Header("Idempotency-Key").empty();
}

/// Of answers that change with what they tell, so that who polls hears nothing twice.
void Tag(const HttpRequest& http, HttpResponse& response) {
  const bool json = response.status == 200 && response.content_type.starts_with("application/json");
  const bool has_one = std::ranges::any_of(
      response.headers, [](const auto& header) { return header.first == "ETag"; });
  if (!json || has_one || response.spool) return;
  std::string tag = "W/\"" + HashSecret(response.payload()).substr(0, 32) + "\"";
  if (http.Header("If-None-Match").find(tag) != std::string_view::npos) {
    response.status = 304;
    response.body.clear();
    response.static_body = {};
  }
  response.headers.emplace_back("ETag", std::move(tag));
}

/// Who asks with the tag of what they know waits for a change, others for the end.
std::chrono::seconds PatienceOf(const ApiRoute& route,
                                const HttpRequest& http,
                                const HttpResponse& response) {
  if (route.query.find("wait") == std::string_view::npos) return {};
  const bool knows_one = !http.Header("If-None-Match").empty();
  const bool waits = knows_one ? response.status == 304 : response.unsettled;
  const auto asked = QueryInteger(http, "wait", 0, 0, kWaitMaxS);
  return std::chrono::seconds(waits && asked.ok() ? asked.value() : 0);
}

}  // namespace

/// Who sends the request, if they may use the route at all.
core::Result<Principal> Gate::CallerOf(const ApiRoute& route, const HttpRequest& http) {
  if (!AsksWho(route)) return Principal{};
  const RequestCredentials credentials{
      http.Header("Cookie"),
      http.Header("Authorization"),
      http.Header(kCsrfHeaderName),
      http.Header("Origin"),
      http.Header("Host"),
      http.remote_address,
      http.method != HttpMethod::kGet && http.method != HttpMethod::kHead};
  TRY(auto who, parts_.api.accounts.Authenticate(credentials, parts_.api.clock.Wall()));
  who.address_key = AddressKey(http.remote_address);
  if (route.by_people && who.proof == Proof::kApiKey) {
    return core::Refuse("scope_lacking", "", {{"scope", "admin"}});
  }
  if (route.guard != Guard::kRole) return who;
  TRY_DONE(Authorize(who, route.operation, Ownership::kNone));
  return who;
}

Admission Gate::Admit(const ApiRoute& route, const HttpRequest& http) {
  auto who = CallerOf(route, http);
  if (!who) return {.refusal = ProblemOf(who.error())};
  const std::string key = who.value().caller_key();
  const bool known = who.value().signed_in();
  if (route.cost != Cost::kTransfer) return {.caller = key, .known = known};
  if (auto slot = transfers_.Take(key)) {
    return {.held = std::move(slot), .caller = key, .known = known};
  }
  constexpr int kSeconds = 2;
  HttpResponse refusal =
      TryAgain(429,
               "Two large downloads or uploads of yours are on their way; wait until one ends.",
               kSeconds);
  auto place = transfers_.Wait(key);
  const bool waits = place != nullptr;
  return {.refusal = std::move(refusal), .not_yet = waits, .held = std::move(place)};
}

/// As Serve looks at it. A database that is away ends nobody's download.
bool Gate::StillMay(const ApiRoute& route, const HttpRequest& http) {
  const auto ended = [](ErrorCode code) {
    return code == ErrorCode::kUnauthorized || code == ErrorCode::kForbidden ||
           code == ErrorCode::kNotFound;
  };
  const auto who = CallerOf(route, http);
  if (!who) return !ended(who.error().code);
  if (route.guard != Guard::kRun) return true;
  const auto run =
      parts_.api.recordings.Find(who.value(), http.PathParameter("id"), route.operation);
  return run.ok() || !ended(run.error().code);
}

RouteAnswer Gate::Serve(const ApiRoute& route, const HttpRequest& http) {
  const auto who = CallerOf(route, http);
  if (!who) return ProblemOf(who.error());
  if (TakesJson(route) && !http.body.empty() &&
      !http.Header("Content-Type").starts_with("application/json")) {
    return Problem(415,
                   "unsupported_media_type",
                   "Unsupported media type",
                   "Send the body as Content-Type: application/json.");
  }
  core::Result<RouteAnswer> answer = Answer(route, http, who.value());
  if (!answer.ok()) return ProblemOf(answer.error());
  const bool is_part = route.lives_at == LivesAt::kEveryMember && http.from_peer;
  if (http.method == HttpMethod::kGet && !is_part) {
    if (auto* response = std::get_if<HttpResponse>(&answer.value())) {
      Tag(http, *response);
      response->patience = PatienceOf(route, http, *response);
    }
  }
  return std::move(answer).value();
}

core::Result<RouteAnswer> Gate::Answer(const ApiRoute& route,
                                       const HttpRequest& http,
                                       const Principal& who) {
  for (const auto& [name, value] : http.path_parameters) {
    if (!core::IsUtf8(value)) {
      return core::Refuse("nothing_here");
    }
  }
  // What the machine below asks ("/healthz", "/metrics") may carry anything.
  if (route.query != "*" && !route.pattern.starts_with('/')) {
    TRY_DONE(OnlyQuery(http, route.query));
    TRY_DONE(QueryInteger(http, "wait", 0, 0, kWaitMaxS));
  }
  RunRecord run;
  if (route.guard == Guard::kRun) {
    TRY(run, parts_.api.recordings.Find(who, http.PathParameter("id"), route.operation));
  }
  TRY(const auto body, BodyOf(route, http));
  const ApiRequest request{http, who, body, run};
  const std::string caller = AsksWho(route) ? who.caller_key() : std::string();
  if (auto elsewhere = parts_.routing.AnsweredElsewhere(route.lives_at, request)) {
    elsewhere->caller = caller;
    if (!http.from_peer) return RouteAnswer(std::move(*elsewhere));
    // The servers' views differ for a moment: nobody passes on what was passed on.
    return RouteAnswer(
        TryAgain(503, "The rig or run of this request is moving to another server.", 1));
  }
  TRY(auto answer,
      Remembers(route, request) ? Remembered(route, request) : route.handler(parts_.api, request));
  if (route.lives_at != LivesAt::kEveryMember || http.from_peer) {
    return RouteAnswer(std::move(answer));
  }
  RouteAnswer joined = parts_.routing.JoinedWithOthers(std::move(answer));
  if (auto* ask = std::get_if<AskPeers>(&joined)) ask->caller = caller;
  return joined;
}

core::Result<HttpResponse> Gate::Remembered(const ApiRoute& route, const ApiRequest& request) {
  const std::string_view key = request.http.Header("Idempotency-Key");
  const bool plain = std::ranges::all_of(key, [](char c) { return c > ' ' && c < 0x7F; });
  if (key.size() > kIdempotencyKeyMax || !plain) {
    return Error{ErrorCode::kInvalid,
                 "At most 200 letters of ASCII.",
                 "Idempotency-Key",
                 "idempotency_key_wrong"};
  }
  IdempotencyStore& answers = parts_.answers;
  const std::string owner = request.who.owner_key();
  const std::string hash =
      HashSecret(std::string(Name(request.http.method)) + " " + std::string(request.http.target) +
                 "\n" + std::string(request.http.body));
  TRY(auto before, answers.Begin(owner, std::string(key), hash, parts_.api.clock.Wall()));
  if (before && route.body.repeat == Repeat::kToldOnce)
    return core::Refuse("answer_told_once", "Idempotency-Key");
  if (before) {
    HttpResponse response;
    response.status = before->status;
    response.body = before->body;
    response.headers.emplace_back("Idempotency-Replayed", "true");
    return response;
  }
  // What was refused has done nothing, and may go better next time.
  bool done = false;
  HttpResponse response;
  std::exception_ptr thrown;
  try {
    const core::Result<HttpResponse> answer = route.handler(parts_.api, request);
    response = answer.ok() ? answer.value() : ProblemOf(answer.error());
    done = response.status < 400;
  } catch (...) {
    thrown = std::current_exception();
  }
  const bool tells = route.body.repeat == Repeat::kAnswered;
  const std::string kept = tells ? std::string(response.payload()) : std::string();
  const core::Status stored = done ? answers.Finish(owner, std::string(key), response.status, kept)
                                   : answers.Forget(owner, std::string(key));
  // Who has been served hears so.
  if (!stored.ok()) parts_.api.log("an answer is not remembered: " + stored.error().message);
  if (thrown) std::rethrow_exception(thrown);
  return response;
}

void Gate::AddRoutes(Router& router, std::span<const ApiRoute> routes) {
  for (const ApiRoute& route : routes) {
    Route entry{route.method,
                (route.pattern.starts_with('/') ? "" : "/api/v1/") + std::string(route.pattern),
                RunsOnOf(route),
                route.body.bytes_max,
                [this, route](const HttpRequest& http) { return Serve(route, http); }};
    if (AsksWho(route)) {
      entry.admit = [this, route](const HttpRequest& http) { return Admit(route, http); };
      entry.always_admit = entry.runs_on == RunsOn::kHeavy;
      entry.still_may = [this, route](const HttpRequest& http) { return StillMay(route, http); };
    }
    // A provider that is stuck leaves threads to the others.
    if (route.cost == Cost::kOutside && route.pattern.find("{id}") != std::string_view::npos) {
      entry.lane = "id";
    }
    entry.from_anywhere = route.body.from_anywhere;
    router.Add(std::move(entry));
  }
}

UpgradeDecision Gate::DecideUpgrade(const HttpRequest& request) {
  if (request.path != "/ws") {
    return Problem(404, "not_found", "Not found", "WebSockets are at /ws.");
  }
  const auto code = request.Query("code");
  if (code && !request.from_peer) {
    if (auto member = parts_.routing.MemberOfCode(*code)) return std::move(*member);
  }
  auto grant = code ? parts_.api.tokens.Redeem(*code) : std::nullopt;
  if (!grant) {
    return Problem(403,
                   "bad_code",
                   "Code not accepted",
                   "The code is unknown, used or older than 30 s; ask for a new stream token.",
                   "code");
  }
  return [&hub = parts_.api.hub, grant = std::move(*grant)](UpgradedSocket socket) {
    hub.Adopt(std::move(socket), grant.run, grant.owner, grant.can_command);
  };
}

}  // namespace faultlab::server
