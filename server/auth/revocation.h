#pragma once

#include <cstdint>
#include <string>

#include "server/auth/principal.h"

namespace faultlab::server {

/// Which rights of an account have ended, told after they have ended in the database. Whatever was
/// opened with them (a WebSocket, a stream code) closes; what is still allowed can be opened again.
struct Revocation {
  enum class What : std::uint8_t {
    kEverything,    ///< password reset, disabled, another role: all that the account has open
    kOtherSignIns,  ///< password changed: all sign-ins but `sign_in`; keys stay
    kSignIn,        ///< signed out: `sign_in` alone
    kApiKeys,       ///< all keys of the account
    kApiKey,        ///< `api_key_id` alone
    kCourse,        ///< no longer a member of `course_id`: what it and the course's teachers saw
  };
  What what = What::kEverything;
  std::int64_t account_id = 0;
  std::string sign_in{};  ///< Principal::session_token_hash
  std::int64_t api_key_id = 0;
  std::int64_t course_id = 0;
};

/// Must what `who` has opened close? For kCourse only of the account itself: whether a teacher may
/// still watch depends on whose run it is.
bool Ends(const Revocation& revocation, const Principal& who);

}  // namespace faultlab::server
