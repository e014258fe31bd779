#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/oidc/claims.h"
#include "server/oidc/login_state.h"
#include "server/oidc/provider.h"

namespace faultlab::server::oidc {

/// The authorization code flow with PKCE, on the server's side.
///
///   browser            this server                        provider
///     |---- Begin ------->| seals state, nonce, verifier       |
///     |<-- cookie, 303 ---|                                    |
///     |----------------------------------- signs in ---------->|
///     |<---------------------------------- 303, code, state ---|
///     |---- Finish ------>|-- code, verifier ----------------->|
///     |                   |<---------------- ID token, userinfo|
///     |                   | Person, or a refusal
///
/// Refusals contain a `reason` for the page; their message is for the log. Both calls block: on
/// pool threads only. Thread-safe.
class SignInFlow {
 public:
  /// @param secret  the key of the seal, shared by the servers of a database; `clock` must outlive
  ///    it
  SignInFlow(std::vector<ProviderSettings> providers, std::string_view secret, const Clock& clock);

  /// In the order of the configuration.
  const std::vector<std::unique_ptr<Provider>>& providers() const { return providers_; }
  /// Null for an unknown id.
  Provider* Find(std::string_view id) const;

  struct Departure {
    std::string location;  ///< at the provider
    std::string sealed;    ///< for the cookie
  };
  core::Result<Departure> Begin(const std::string& provider,
                                const std::string& redirect_uri,
                                const std::string& next,
                                std::int64_t add_to);

  /// The parameters of a callback, unchanged.
  struct Callback {
    std::string provider;
    std::string sealed;  ///< the cookie
    std::string state;
    std::string code;
    std::string issuer;
    bool has_issuer = false;
    std::string error;
  };
  struct Arrival {
    Person person;
    LoginState state;
  };
  core::Result<Arrival> Finish(const Callback& callback);

 private:
  core::Result<Person> Ask(Provider& provider, const LoginState& state, const Callback& callback);

  const Clock& clock_;
  const LoginSeal seal_;
  std::vector<std::unique_ptr<Provider>> providers_;
};

}  // namespace faultlab::server::oidc
