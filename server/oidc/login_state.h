#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/wall_time.h"

namespace faultlab::server::oidc {

/// A sign-in that has left for the provider. It travels in a cookie of the browser that began it,
/// sealed, so strangers who begin sign-ins fill nothing here, any server of the lab can finish it,
/// and nobody can finish it in another browser.
struct LoginState {
  std::string provider;
  std::string state;         ///< goes to the provider and back
  std::string nonce;         ///< comes back in the ID token
  std::string verifier;      ///< PKCE: goes only to the token endpoint
  std::string redirect_uri;  ///< of the callback
  std::string next;          ///< where on this site to go afterwards
  std::int64_t add_to = 0;   ///< account that asks to be known by this identity too; 0: a sign-in
  WallTime began{};
};

inline constexpr auto kLoginLives = std::chrono::minutes(10);

/// Seals and opens with a key that the servers of one database share.
class LoginSeal {
 public:
  /// @param secret  random, of any length
  explicit LoginSeal(std::string_view secret);

  /// Letters of base64url.
  std::string Close(const LoginState& state) const;
  /// Nothing when it was not sealed here, or more than 10 min ago.
  std::optional<LoginState> Open(std::string_view text, WallTime now) const;

 private:
  std::string key_;
};

/// 32 random bytes as base64url: states, nonces, verifiers.
std::string RandomText();
/// BASE64URL(SHA256(verifier)): code_challenge of PKCE S256.
std::string ChallengeOf(std::string_view verifier);
/// A path on this site, for a browser to go to: `text` if it is one, else "/my".
std::string PathHere(std::string_view text);

}  // namespace faultlab::server::oidc
