#include <boost/json.hpp>
#include <charconv>

#include "server/api/json_reader.h"
#include "server/api/lab/handlers.h"
#include "server/auth/secrets.h"
#include "server/lab/remembered_answers.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;

constexpr std::size_t kIdempotencyKeyMax = 200;

}  // namespace

core::Result<LabApi*> LabOf(ApiContext& api) {
  if (api.lab != nullptr) return api.lab;
  return Error{ErrorCode::kNotFound, "This server has no accounts and no queue.", ""};
}

core::Result<std::int64_t> PathNumber(const ApiRequest& request, std::string_view name) {
  const std::string& text = request.http.PathParameter(name);
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error == std::errc() && end == text.data() + text.size() && number > 0) return number;
  return Error{ErrorCode::kNotFound, "There is no such thing.", ""};
}

core::Result<std::int64_t> RequiredVersion(const ApiRequest& request) {
  std::string_view text = request.http.Header("If-Match");
  if (text.starts_with("W/")) text.remove_prefix(2);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
    text = text.substr(1, text.size() - 2);
  }
  std::int64_t version = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), version);
  if (!text.empty() && error == std::errc() && end == text.data() + text.size()) return version;
  return Error{ErrorCode::kInvalid,
               "Send If-Match with the version that you saw, for example If-Match: \"3\".",
               "If-Match"};
}

core::Result<Ownership> RelationTo(ApiContext& api,
                                   const Principal& who,
                                   std::string_view owner_key) {
  const Ownership whose = OwnershipOf(who, owner_key);
  constexpr std::string_view kUserKey = "user:";
  if (whose == Ownership::kOwn || !api.lab || !who.signed_in()) return whose;
  if (!owner_key.starts_with(kUserKey)) return whose;
  const std::string_view text = owner_key.substr(kUserKey.size());
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  if (error != std::errc() || end != text.data() + text.size()) return whose;
  return api.lab->accounts.Relation(who, id);
}

core::Status NoBody(const ApiRequest& request) {
  auto body = ParseJsonObject(request.http.body);
  if (!body) return body.error();
  ObjectReader in(body.value(), "");
  if (auto error = in.Finish()) return *error;
  return core::Done{};
}

HttpResponse NoContent() {
  HttpResponse response;
  response.status = 204;
  return response;
}

void Audit(ApiContext& api,
           const Principal& who,
           const std::string& verb,
           const std::string& object,
           const std::string& detail) {
  const std::string actor = who.owner_key();
  const core::Status kept = api.lab->accounts.Audit(actor, verb, object, detail, api.clock.Wall());
  if (kept.ok()) return;
  // The deed is done and stored: it is not refused any more.
  api.lab->log("audit: \"" + verb + " " + object + "\" by " + actor +
               " is not in the audit log: " + kept.error().message);
}

core::Result<HttpResponse> Remembered(ApiContext& api,
                                      const ApiRequest& request,
                                      ApiHandler handler) {
  const std::string_view key = request.http.Header("Idempotency-Key");
  if (key.empty() || api.lab == nullptr || !request.who.signed_in()) return handler(api, request);
  if (key.size() > kIdempotencyKeyMax) {
    return Error{ErrorCode::kInvalid, "At most 200 bytes.", "Idempotency-Key"};
  }
  lab::RememberedAnswers& answers = api.lab->answers;
  const std::string owner = request.who.owner_key();
  const std::string hash =
      HashSecret(std::string(Name(request.http.method)) + " " + std::string(request.http.target) +
                 "\n" + std::string(request.http.body));
  auto before = answers.Begin(owner, std::string(key), hash, api.clock.Wall());
  if (!before) return before.error();
  if (before.value()) {
    HttpResponse response;
    response.status = before.value()->status;
    response.body = before.value()->body;
    if (response.status >= 400) response.content_type = "application/problem+json";
    response.headers.emplace_back("Idempotency-Replayed", "true");
    return response;
  }
  const core::Result<HttpResponse> answer = handler(api, request);
  const HttpResponse response = answer.ok() ? answer.value() : ProblemOf(answer.error());
  // What may go better next time is not remembered.
  const core::Status kept =
      response.status >= 500
          ? answers.Forget(owner, std::string(key))
          : answers.Finish(
                owner, std::string(key), response.status, std::string(response.payload()));
  if (!kept.ok()) return kept.error();
  return response;
}

}  // namespace faultlab::server
