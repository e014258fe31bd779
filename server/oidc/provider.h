#pragma once

#include <boost/json/object.hpp>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/oidc/https_client.h"
#include "server/oidc/jwk.h"
#include "server/oidc/provider_documents.h"
#include "server/oidc/provider_settings.h"

namespace faultlab::server::oidc {

/// Talks to one provider: its documents are fetched when they are first needed and kept. After a
/// question without an answer nobody waits for it again for 5 s: until then whoever asks is refused
/// at once. Such refusals have the reason kAway. What blocks is said so: on pool threads only.
/// Thread-safe.
class Provider {
 public:
  static constexpr const char* kAway = "oidc_away";

  /// `clock` must outlive it.
  Provider(ProviderSettings settings, const Clock& clock);

  const ProviderSettings& settings() const { return settings_; }

  /// Blocks when it is not known yet. After a failure it is not asked again for 10 s.
  core::Result<Discovery> Discover();

  struct Tokens {
    std::string id_token;
    std::string access_token;
  };
  /// Blocks. The code of a callback for tokens.
  core::Result<Tokens> Exchange(const Discovery& discovery,
                                const std::string& code,
                                const std::string& verifier,
                                const std::string& redirect_uri);
  /// Blocks when keys are fetched: at first, and for a key that is not known, once a minute. The
  /// claims of a token that is the provider's; what they say is not checked.
  core::Result<boost::json::object> ClaimsOf(const Discovery& discovery, std::string_view token);
  /// Blocks. What the userinfo endpoint says of `subject`.
  core::Result<boost::json::object> UserInfo(const Discovery& discovery,
                                             const std::string& access_token,
                                             const std::string& subject);

 private:
  core::Result<WebAnswer> Ask(const WebRequest& request);
  core::Result<std::vector<Jwk>> Keys(const Discovery& discovery, bool newer);

  const ProviderSettings settings_;
  const Clock& clock_;
  const HttpsClient client_;
  std::mutex mutex_;                        ///< of what follows; not held while anybody is asked
  std::optional<MonotonicTime> silent_at_;  ///< it gave no answer then, and none since
  std::optional<Discovery> discovery_;
  MonotonicTime discovered_at_{};
  std::optional<core::Error> discovery_failed_;
  bool discovering_ = false;
  std::vector<Jwk> keys_;
  std::optional<MonotonicTime> keys_asked_at_;
};

}  // namespace faultlab::server::oidc
