#pragma once

#include <cstdint>
#include <string>

#include "server/auth/principal.h"

namespace faultlab::server {

/// The rights of an account that have ended; sent after they have ended in the database. Everything
/// opened with them (a WebSocket, a stream code) is closed; what is still allowed can be opened
/// again.
struct Revocation {
  enum class What : std::uint8_t {
    kEverything,    ///< password reset, disabled, role changed: all that is open
    kOtherSignIns,  ///< password changed: all sign-ins except `sign_in`; keys stay valid
    kSignIn,        ///< signed out: only `sign_in`
    kApiKeys,       ///< all keys of the account
    kApiKey,        ///< only `api_key_id`
    kCourse,        ///< no longer a member of `course_id`; also what its teachers saw
  };
  What what = What::kEverything;
  std::int64_t account_id = 0;
  std::string sign_in{};  ///< Principal::session_token_hash
  std::int64_t api_key_id = 0;
  std::int64_t course_id = 0;
};

/// Whether what `who` has opened must be closed. For kCourse this concerns only the account itself:
/// whether a teacher may still watch depends on the run's owner.
bool Ends(const Revocation& revocation, const Principal& who);

}  // namespace faultlab::server
