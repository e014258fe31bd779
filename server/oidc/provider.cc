#include "server/oidc/provider.h"

#include <sodium.h>

#include <utility>

#include "server/oidc/claims.h"
#include "server/oidc/jwt.h"

namespace faultlab::server::oidc {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;
using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr auto kDocumentsLive = hours(1);
constexpr auto kKeysPause = minutes(1);
constexpr auto kFailurePause = seconds(10);
constexpr auto kSilencePause = seconds(5);
constexpr int kOk = 200;

std::string PlainBase64(const std::string& text) {
  std::string out(sodium_base64_encoded_len(text.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(out.data(),
                    out.size(),
                    reinterpret_cast<const unsigned char*>(text.data()),
                    text.size(),
                    sodium_base64_VARIANT_ORIGINAL);
  out.pop_back();  // the terminating zero
  return out;
}

}  // namespace

Provider::Provider(ProviderSettings settings, const Clock& clock)
    : settings_(std::move(settings)),
      clock_(clock),
      client_({.ca_file = settings_.ca_file, .insecure_loopback = settings_.insecure_loopback}) {}

core::Result<WebAnswer> Provider::Ask(const WebRequest& request) {
  {
    const std::lock_guard lock(mutex_);
    if (silent_at_ && clock_.Monotonic() - *silent_at_ < kSilencePause) {
      return Error{ErrorCode::kUnavailable, "the provider gave no answer just now", "", kAway};
    }
  }
  auto answer = client_.Ask(request);
  const std::lock_guard lock(mutex_);
  silent_at_.reset();
  if (answer.ok() || answer.error().code == ErrorCode::kTooLarge) return answer;
  silent_at_ = clock_.Monotonic();
  return Error{answer.error().code, answer.error().message, "", kAway};
}

core::Result<Discovery> Provider::Discover() {
  {
    const std::lock_guard lock(mutex_);
    const auto age = clock_.Monotonic() - discovered_at_;
    if (discovery_ && (age < kDocumentsLive || discovering_)) return *discovery_;
    if (discovery_failed_ && age < kFailurePause) return *discovery_failed_;
    if (discovering_) return Error{ErrorCode::kUnavailable, "the provider is being asked", ""};
    discovering_ = true;
  }
  const auto answer = Ask({DiscoveryUrl(settings_.issuer), {"Accept: application/json"}});
  auto parsed = answer.ok() ? ParseDiscovery(answer.value(), settings_.issuer, client_)
                            : core::Result<Discovery>(answer.error());
  const std::lock_guard lock(mutex_);
  discovering_ = false;
  discovered_at_ = clock_.Monotonic();
  discovery_failed_.reset();
  if (parsed.ok()) discovery_ = parsed.value();
  if (!parsed.ok()) discovery_failed_ = parsed.error();
  if (!parsed.ok() && discovery_) return *discovery_;  // use the document of an hour ago
  return parsed;
}

core::Result<Provider::Tokens> Provider::Exchange(const Discovery& discovery,
                                                  const std::string& code,
                                                  const std::string& verifier,
                                                  const std::string& redirect_uri) {
  WebRequest request;
  request.url = discovery.token_endpoint;
  request.headers = {"Accept: application/json"};
  request.body = "grant_type=authorization_code&code=" + FormEncode(code) +
                 "&redirect_uri=" + FormEncode(redirect_uri) +
                 "&code_verifier=" + FormEncode(verifier);
  const std::string id = FormEncode(settings_.client_id);
  if (settings_.client_secret.empty() || discovery.secret_in_form) {
    request.body += "&client_id=" + id;
  }
  if (!settings_.client_secret.empty()) {
    const std::string secret = FormEncode(settings_.client_secret);
    if (discovery.secret_in_form) request.body += "&client_secret=" + secret;
    if (!discovery.secret_in_form) {
      request.headers.push_back("Authorization: Basic " + PlainBase64(id + ":" + secret));
    }
  }
  TRY(const auto answer, Ask(request));
  TRY(const auto object, ObjectOf(answer, "the token endpoint"));
  Tokens out{TextOf(object, "id_token"), TextOf(object, "access_token")};
  if (out.id_token.empty()) {
    return Error{ErrorCode::kUnavailable, "the token endpoint gave no ID token", ""};
  }
  return out;
}

core::Result<std::vector<Jwk>> Provider::Keys(const Discovery& discovery, bool newer) {
  {
    const std::lock_guard lock(mutex_);
    if (keys_asked_at_) {
      const auto age = clock_.Monotonic() - *keys_asked_at_;
      if (age < kKeysPause && keys_.empty()) {
        return Error{ErrorCode::kUnavailable, "the provider is being asked", "", kAway};
      }
      if (age < kKeysPause || (!newer && age < kDocumentsLive)) return keys_;
    }
    keys_asked_at_ = clock_.Monotonic();  // meanwhile other threads use the known keys
  }
  const auto answer = Ask({discovery.jwks_uri, {"Accept: application/json"}});
  const bool good = answer.ok() && answer.value().status == kOk;
  const std::string reason = answer.ok() ? "" : answer.error().reason;
  auto parsed =
      good ? ParseJwks(answer.value().body)
           : core::Result<std::vector<Jwk>>(
                 Error{ErrorCode::kUnavailable, "the provider's keys are not there", "", reason});
  const std::lock_guard lock(mutex_);
  if (parsed.ok()) keys_ = parsed.value();
  if (!parsed.ok() && !keys_.empty()) return keys_;
  if (!parsed.ok()) keys_asked_at_.reset();  // first fetch: the next sign-in tries again
  return parsed;
}

core::Result<json::object> Provider::ClaimsOf(const Discovery& discovery, std::string_view token) {
  TRY(const auto apart, TakeApart(token));
  core::Result<json::object> claims =
      Error{ErrorCode::kInvalid, "the token names a key that the provider does not publish", ""};
  for (const bool newer : {false, true}) {
    TRY(const auto keys, Keys(discovery, newer));
    if (const Jwk* key = KeyOf(apart.header, keys)) {
      claims = Prove(apart, *key);
    }
    if (claims.ok()) break;
  }
  return claims;
}

core::Result<json::object> Provider::UserInfo(const Discovery& discovery,
                                              const std::string& access_token,
                                              const std::string& subject) {
  if (discovery.userinfo_endpoint.empty() || access_token.empty()) return json::object{};
  if (access_token.find_first_of("\r\n") != std::string::npos) {
    return Error{ErrorCode::kInvalid, "the access token is no token", ""};
  }
  TRY(const auto answer,
      Ask({discovery.userinfo_endpoint,
           {"Accept: application/json", "Authorization: Bearer " + access_token}}));
  TRY(auto object, ObjectOf(answer, "the userinfo endpoint"));
  if (TextOf(object, "sub") != subject) {
    return Error{ErrorCode::kInvalid, "the userinfo endpoint speaks of somebody else", ""};
  }
  return object;
}

}  // namespace faultlab::server::oidc
