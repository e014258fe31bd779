#pragma once

#include <boost/json/object.hpp>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/oidc/jwk.h"
#include "server/oidc/provider_documents.h"
#include "server/oidc/provider_settings.h"
#include "server/web_client/web_client.h"

namespace faultlab::server::oidc {

/// Communicates with one provider: its documents are fetched when they are first needed, and kept.
/// If a request gets no answer, further requests are refused at once for 5 s; such refusals have
/// the reason kAway. Functions that block say so: on pool threads only. Thread-safe.
class Provider {
 public:
  static constexpr const char* kAway = "oidc_away";

  /// `clock` must outlive it.
  Provider(ProviderSettings settings, const Clock& clock);

  const ProviderSettings& settings() const { return settings_; }

  /// Blocks if it is not known yet. After a failure it is not fetched again for 10 s.
  core::Result<Discovery> Discover();

  struct Tokens {
    std::string id_token;
    std::string access_token;
  };
  /// Blocks. Exchanges the code of a callback for tokens.
  core::Result<Tokens> Exchange(const Discovery& discovery,
                                const std::string& code,
                                const std::string& verifier,
                                const std::string& redirect_uri);
  /// Blocks when keys are fetched: at first, and for an unknown key, at most once a minute. Returns
  /// the claims of a token signed by the provider; the claims themselves are not checked.
  core::Result<boost::json::object> ClaimsOf(const Discovery& discovery, std::string_view token);
  /// Blocks. The answer of the userinfo endpoint about `subject`.
  core::Result<boost::json::object> UserInfo(const Discovery& discovery,
                                             const std::string& access_token,
                                             const std::string& subject);

 private:
  core::Result<WebAnswer> Ask(const WebRequest& request);
  core::Result<std::vector<Jwk>> Keys(const Discovery& discovery, bool newer);

  const ProviderSettings settings_;
  const Clock& clock_;
  const WebClient client_;
  std::mutex mutex_;                        ///< guards the following; not held during requests
  std::optional<MonotonicTime> silent_at_;  ///< time of a request without an answer
  std::optional<Discovery> discovery_;
  MonotonicTime discovered_at_{};
  std::optional<core::Error> discovery_failed_;
  bool discovering_ = false;
  std::vector<Jwk> keys_;
  std::optional<MonotonicTime> keys_asked_at_;
};

}  // namespace faultlab::server::oidc
