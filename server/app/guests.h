#pragma once

#include <string>

#include "server/auth/authenticator.h"

namespace faultlab::server {

/// Nobody has an account: whoever may come in is the guest.
class GuestsOnly : public Authenticator {
 public:
  /// @param from  "loopback", "everywhere" or "never"
  explicit GuestsOnly(std::string from) : from_(std::move(from)) {}

  core::Result<Principal> Authenticate(const RequestCredentials& credentials,
                                       WallTime now) override;

 private:
  std::string from_;
};

}  // namespace faultlab::server
