#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/wall_time.h"

namespace faultlab::server::oidc {

/// A sign-in that is in progress at the provider. It is stored, sealed, in a cookie of the browser
/// that began it. Therefore sign-ins begun by strangers use no memory here, any server of the lab
/// can finish a sign-in, and nobody can finish it in another browser.
struct LoginState {
  std::string provider;
  std::string state;         ///< sent to the provider and returned
  std::string nonce;         ///< returned in the ID token
  std::string verifier;      ///< PKCE: sent only to the token endpoint
  std::string redirect_uri;  ///< of the callback
  std::string next;          ///< path on this site to go to afterwards
  std::int64_t add_to = 0;   ///< account to which this identity is to be added; 0: a sign-in
  WallTime began{};
};

inline constexpr auto kLoginLives = std::chrono::minutes(10);

/// Seals and opens with a key that the servers of one database share.
class LoginSeal {
 public:
  /// @param secret  random, of any length
  explicit LoginSeal(std::string_view secret);

  /// The sealed state, in letters of base64url.
  std::string Close(const LoginState& state) const;
  /// Nothing if it was not sealed with this key, or longer ago.
  std::optional<LoginState> Open(std::string_view text,
                                 WallTime now,
                                 std::chrono::minutes lives = kLoginLives) const;

 private:
  std::string key_;
};

/// 32 random bytes as base64url: states, nonces, verifiers.
std::string RandomText();
/// BASE64URL(SHA256(verifier)): code_challenge of PKCE S256.
std::string ChallengeOf(std::string_view verifier);
/// A path on this site to which a browser may be sent: `text` if it is one, otherwise "/my".
std::string PathHere(std::string_view text);

}  // namespace faultlab::server::oidc
