#include "server/lti/platform_client.h"

#include <algorithm>
#include <boost/json.hpp>

#include "server/oidc/claims.h"
#include "server/oidc/jwk.h"
#include "server/oidc/provider_documents.h"
#include "server/storage/ids.h"

namespace faultlab::server::lti {
namespace {

namespace json = boost::json;
using core::Error;
using core::ErrorCode;
using std::chrono::seconds;

constexpr std::size_t kAddressBytesMax = 2000;
constexpr seconds kAssertionLives{300};
constexpr seconds kTokenMargin{60};
constexpr double kTokenMaxS = 3600.0;

std::int64_t SecondsOf(WallTime time) {
  return std::chrono::floor<seconds>(time).time_since_epoch().count();
}

}  // namespace

std::string_view OriginOf(std::string_view url) {
  const std::size_t scheme = url.find("://");
  return url.substr(0, url.find_first_of("/?#", scheme == std::string_view::npos ? 0 : scheme + 3));
}

PlatformClient::PlatformClient(const ToolKey& key, const Reach& reach, const Clock& clock)
    : key_(key),
      client_({.ca_file = reach.ca_file, .insecure_loopback = reach.insecure_loopback}),
      clock_(clock) {}

core::Status PlatformClient::CheckUrl(const std::string& url, const std::string& field) const {
  const bool printable = url.find_first_of(" \t\r\n\"'<>\\") == std::string::npos;
  if (url.size() <= kAddressBytesMax && printable && client_.CheckUrl(url).ok()) {
    return core::Done{};
  }
  return core::Refuse("platform_url_wrong", field);
}

core::Result<WebAnswer> PlatformClient::AskAs(const Platform& platform,
                                              std::string_view scope,
                                              WebRequest request) {
  const std::vector<std::string> headers = request.headers;
  for (const bool fresh : {false, true}) {
    const auto token = TokenOf(platform, scope, fresh);
    if (!token) return Error{ErrorCode::kUnavailable, token.error().message, ""};
    request.headers = headers;
    request.headers.push_back("Authorization: Bearer " + token.value());
    auto answer = client_.Ask(request);
    if (!answer.ok() || answer.value().status != 401 || fresh) return answer;
  }
  return Error{ErrorCode::kUnavailable, "the platform takes no token", ""};
}

core::Result<std::size_t> PlatformClient::CountKeys(const Platform& platform) const {
  TRY(const auto answer, client_.Ask({platform.keys_url, {"Accept: application/json"}}));
  if (answer.status != 200) {
    return Error{ErrorCode::kUnavailable, "the keys answer " + std::to_string(answer.status), ""};
  }
  TRY(const auto keys, oidc::ParseJwks(answer.body));
  return keys.size();
}

core::Status PlatformClient::CheckToken(const Platform& platform) {
  const auto token = TokenOf(platform, kScoreScope, /*fresh=*/true);
  return token.ok() ? core::Status(core::Done{}) : token.error();
}

core::Result<std::string> PlatformClient::TokenOf(const Platform& platform,
                                                  std::string_view scope,
                                                  bool fresh) {
  // A platform that is registered anew begins anew.
  const std::string of = NameOf(platform.id) + " " + platform.client_id + " " + platform.token_url +
                         " " + std::string(scope);
  if (!fresh) {
    const std::lock_guard lock(mutex_);
    const auto known = tokens_.find(of);
    if (known != tokens_.end() && clock_.Monotonic() < known->second.until) {
      return known->second.text;
    }
  }
  const WallTime now = clock_.Wall();
  const std::string assertion = key_.Sign({{"iss", platform.client_id},
                                           {"sub", platform.client_id},
                                           {"aud", platform.token_url},
                                           {"iat", SecondsOf(now)},
                                           {"exp", SecondsOf(now + kAssertionLives)},
                                           {"jti", NewId("jti")}});
  WebRequest request;
  request.url = platform.token_url;
  request.headers = {"Accept: application/json"};
  request.body = "grant_type=client_credentials&client_assertion_type=" +
                 FormEncode("urn:ietf:params:oauth:client-assertion-type:jwt-bearer") +
                 "&client_assertion=" + FormEncode(assertion) +
                 "&scope=" + FormEncode(std::string(scope));
  TRY(const auto answer, client_.Ask(request));
  TRY(const auto object, oidc::ObjectOf(answer, "the platform's token address"));
  Token token{oidc::TextOf(object, "access_token"), {}};
  const bool plain = token.text.find_first_of("\r\n") == std::string::npos;
  if (token.text.empty() || !plain) {
    return Error{ErrorCode::kUnavailable, "the platform gave no token", ""};
  }
  const json::value* lives = object.if_contains("expires_in");
  const double given_s = lives != nullptr && lives->is_number() ? lives->to_number<double>() : 0.0;
  token.until =
      clock_.Monotonic() +
      std::max(seconds{0},
               seconds{static_cast<int>(std::clamp(given_s, 0.0, kTokenMaxS))} - kTokenMargin);
  const std::lock_guard lock(mutex_);
  tokens_[of] = token;
  return token.text;
}

}  // namespace faultlab::server::lti
