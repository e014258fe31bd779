#include "server/oidc/sign_in_flow.h"

#include <sodium.h>

#include "server/oidc/id_token.h"

namespace faultlab::server::oidc {
namespace {

using core::Error;
using core::ErrorCode;

constexpr std::size_t kCodeBytesMax = 4096;

Error Refusal(ErrorCode code, const std::string& reason, const std::string& message) {
  return {code, message, "", reason};
}

Error Away(const Error& cause) {
  return Refusal(ErrorCode::kUnavailable, Provider::kAway, cause.message);
}

Error Failed(const std::string& why) {
  return Refusal(ErrorCode::kForbidden, "oidc_failed", why);
}

/// The refusal when a request to the provider fails during a sign-in.
Error Failed(const Error& cause) {
  return cause.reason == Provider::kAway ? Away(cause) : Failed(cause.message);
}

bool Same(const std::string& a, const std::string& b) {
  return a.size() == b.size() && !a.empty() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

/// The provider has stated its issuer, and it is the expected one (RFC 9207).
core::Status CheckIssuer(const SignInFlow::Callback& callback, const Discovery& discovery) {
  if (callback.has_issuer && callback.issuer != discovery.issuer) {
    return Failed("the answer is of the issuer " + ForLog(callback.issuer));
  }
  if (!callback.has_issuer && discovery.says_issuer) {
    return Failed("the answer does not say its issuer, and this provider always does");
  }
  return core::Done{};
}

}  // namespace

SignInFlow::SignInFlow(std::vector<ProviderSettings> providers,
                       std::string_view secret,
                       const Clock& clock)
    : clock_(clock), seal_(secret) {
  for (ProviderSettings& settings : providers) {
    providers_.push_back(std::make_unique<Provider>(std::move(settings), clock));
  }
}

Provider* SignInFlow::Find(std::string_view id) const {
  for (const auto& provider : providers_) {
    if (provider->settings().id == id) return provider.get();
  }
  return nullptr;
}

core::Result<SignInFlow::Departure> SignInFlow::Begin(const std::string& provider_id,
                                                      const std::string& redirect_uri,
                                                      const std::string& next,
                                                      std::int64_t add_to) {
  Provider* provider = Find(provider_id);
  if (provider == nullptr) return core::Refuse("no_provider");
  const auto discovery = provider->Discover();
  if (!discovery) return Away(discovery.error());
  const ProviderSettings& settings = provider->settings();
  LoginState state;
  state.provider = provider_id;
  state.state = RandomText();
  state.nonce = RandomText();
  state.verifier = RandomText();
  state.redirect_uri = redirect_uri;
  state.next = PathHere(next);
  state.add_to = add_to;
  state.began = clock_.Wall();
  std::string scopes;
  for (const std::string& scope : settings.scopes) scopes += (scopes.empty() ? "" : " ") + scope;
  const std::string& endpoint = discovery.value().authorization_endpoint;
  std::string location = endpoint + (endpoint.find('?') == std::string::npos ? "?" : "&");
  location += "response_type=code&client_id=" + FormEncode(settings.client_id) +
              "&redirect_uri=" + FormEncode(redirect_uri) + "&scope=" + FormEncode(scopes) +
              "&state=" + state.state + "&nonce=" + state.nonce +
              "&code_challenge=" + ChallengeOf(state.verifier) + "&code_challenge_method=S256";
  return Departure{std::move(location), seal_.Close(state)};
}

core::Result<SignInFlow::Arrival> SignInFlow::Finish(const Callback& callback) {
  auto state = seal_.Open(callback.sealed, clock_.Wall());
  const bool ours =
      state && state->provider == callback.provider && Same(state->state, callback.state);
  Provider* provider = Find(callback.provider);
  if (!ours || provider == nullptr) {
    return Refusal(ErrorCode::kForbidden,
                   "oidc_elsewhere",
                   "the answer is not to a sign-in that this browser began in the last 10 min");
  }
  TRY(const auto person, Ask(*provider, *state, callback));
  return Arrival{person, std::move(*state)};
}

core::Result<Person> SignInFlow::Ask(Provider& provider,
                                     const LoginState& state,
                                     const Callback& callback) {
  const auto discovery = provider.Discover();
  if (!discovery) return Away(discovery.error());
  if (const auto same = CheckIssuer(callback, discovery.value()); !same.ok()) return same.error();
  if (!callback.error.empty()) {
    const bool denied = callback.error == "access_denied";
    return Refusal(ErrorCode::kForbidden,
                   denied ? "oidc_denied" : "oidc_failed",
                   "the provider said " + ForLog(callback.error));
  }
  if (callback.code.empty() || callback.code.size() > kCodeBytesMax) return Failed("no code came");
  const auto tokens =
      provider.Exchange(discovery.value(), callback.code, state.verifier, state.redirect_uri);
  if (!tokens) return Failed(tokens.error());
  auto claims = provider.ClaimsOf(discovery.value(), tokens.value().id_token);
  if (!claims) return Failed(claims.error());
  const core::Status good = CheckIdToken(claims.value(),
                                         {provider.settings().issuer,
                                          provider.settings().client_id,
                                          state.nonce,
                                          tokens.value().access_token,
                                          clock_.Wall()});
  if (!good.ok()) return Failed(good.error().message);
  const auto more = provider.UserInfo(
      discovery.value(), tokens.value().access_token, TextOf(claims.value(), "sub"));
  if (!more) return Failed(more.error());
  for (const auto& claim : more.value()) claims.value().insert(claim);  // only absent ones
  const auto person = Admit(claims.value(), provider.settings().admission);
  if (!person) return Refusal(ErrorCode::kForbidden, "oidc_not_allowed", person.error().message);
  return person;
}

}  // namespace faultlab::server::oidc
