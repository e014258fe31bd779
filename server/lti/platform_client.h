#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/lti/platforms.h"
#include "server/lti/tool_key.h"
#include "server/web_client/web_client.h"

namespace faultlab::server::lti {

/// What a platform may grant this lab, and a token is for: to send scores, to read who is in a
/// course.
inline constexpr std::string_view kScoreScope =
    "https://purl.imsglobal.org/spec/lti-ags/scope/score";
inline constexpr std::string_view kRosterScope =
    "https://purl.imsglobal.org/spec/lti-nrps/scope/contextmembership.readonly";

/// How this lab reaches platforms.
struct Reach {
  std::string ca_file;             ///< PEM; empty: the system's
  bool insecure_loopback = false;  ///< http://127.0.0.1, for tests
};

/// Scheme, host and port of an address.
std::string_view OriginOf(std::string_view url);

/// Asks platforms, with tokens where they want one (OAuth 2 client credentials, RFC 7523). All but
/// CheckUrl blocks: never on a network thread. Thread-safe.
class PlatformClient {
 public:
  /// Both must outlive it.
  PlatformClient(const ToolKey& key, const Reach& reach, const Clock& clock);

  /// kInvalid, reason "platform_url_wrong": it may not be asked.
  core::Status CheckUrl(const std::string& url, const std::string& field = {}) const;
  core::Result<WebAnswer> Ask(const WebRequest& request) const { return client_.Ask(request); }
  /// With a token of this scope: the one that is known, or a fresh one where that has ended before
  /// its time. kTooLarge is always of the answer, not of the token.
  core::Result<WebAnswer> AskAs(const Platform& platform,
                                std::string_view scope,
                                WebRequest request);

  /// The keys of a platform are there: how many; or why not.
  core::Result<std::size_t> CountKeys(const Platform& platform) const;
  /// A token for grades is given; or why not.
  core::Status CheckToken(const Platform& platform);

 private:
  struct Token {
    std::string text;
    MonotonicTime until{};
  };
  core::Result<std::string> TokenOf(const Platform& platform, std::string_view scope, bool fresh);

  const ToolKey& key_;
  const WebClient client_;
  const Clock& clock_;
  std::mutex mutex_;
  std::map<std::string, Token> tokens_;  ///< by what they were asked with
};

}  // namespace faultlab::server::lti
