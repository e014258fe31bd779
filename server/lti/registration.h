#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/lti/platform_client.h"
#include "server/lti/platforms.h"
#include "server/oidc/login_state.h"

namespace faultlab::server::lti {

/// What a platform must know of this lab.
struct ToolAddresses {
  std::string login, launch, keys;
};
/// @param base  as browsers reach this server: "https://lab.example.org"
ToolAddresses ToolAt(const std::string& base);

/// LTI Dynamic Registration 1.0: instead of five values, an admin of this lab hands one address to
/// the admin of a platform, who opens it there.
///
///   admin here            platform              this lab
///     |-- the address ------->|                     |
///     |                       |-- configuration? -->| Open: it is ours, and fresh
///     |                       |<---- what it is? ---| Read
///     |                       |<- this is our lab --| Enter
///     |                       |--- a client ID ---->| Platform
///
/// Read and Enter block: on pool threads only. Their refusals have the reason
/// "lti_register_failed", and their message is for the platform's admin. Immutable, thread-safe.
class Registration {
 public:
  static constexpr auto kLives = std::chrono::hours(1);

  /// @param secret  shared by the servers of a database; the others must outlive it
  Registration(std::string_view secret, const PlatformClient& client, const Clock& clock)
      : client_(client), clock_(clock), seal_("lti register " + std::string(secret)) {}

  /// Who knows it may register one platform within kLives.
  std::string Invite(std::int64_t admin) const;
  struct Invitation {
    std::int64_t admin = 0;
    std::string state;  ///< to be used once
  };
  /// "lti_register_over"
  core::Result<Invitation> Open(std::string_view sealed) const;

  /// What a platform says of itself.
  struct Offer {
    Platform platform;  ///< but for its client_id
    std::string endpoint;
    std::string scopes;
  };
  core::Result<Offer> Read(const std::string& configuration_url) const;
  core::Result<Platform> Enter(const Offer& offer,
                               const std::string& token,
                               const ToolAddresses& tool) const;

 private:
  const PlatformClient& client_;
  const Clock& clock_;
  const oidc::LoginSeal seal_;
};

}  // namespace faultlab::server::lti
