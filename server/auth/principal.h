#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/net/http.h"

namespace faultlab::server {

enum class Role : std::uint8_t { kGuest, kStudent, kInstructor, kOperator, kAdmin, kService };

constexpr std::string_view Name(Role role) {
  switch (role) {
    case Role::kGuest:
      return "guest";
    case Role::kStudent:
      return "student";
    case Role::kInstructor:
      return "instructor";
    case Role::kOperator:
      return "operator";
    case Role::kAdmin:
      return "admin";
    case Role::kService:
      return "service";
  }
  return "?";
}

/// Who asks.
struct Principal {
  Role role = Role::kGuest;
  std::string id;    ///< stable; "guest" for guests
  std::string name;  ///< for people
  std::vector<std::string> scopes;  ///< of an API key; empty for people
  bool by_cookie = false;           ///< unsafe requests then need the CSRF defence
};

/// What a route needs. The table role x permission is in one place: the Authorizer.
enum class Permission : std::uint8_t {
  kPublic,         ///< no question asked; the Authenticator is not even called
  kSignedIn,       ///< anybody the Authenticator lets in, guests included
  kReadRuns,       ///< runs, recordings, plots, exports that the principal may see
  kStartRuns,      ///< start and stop runs
  kUpload,         ///< upload recordings
  kReadRigs,
  kOperateRigs,
  kTeach,
  kAdminister,
};

/// The seam where accounts enter. Called on a pool thread, so it may ask the database.
class Authenticator {
 public:
  virtual ~Authenticator() = default;
  /// kUnauthorized when credentials are needed or wrong.
  virtual core::Result<Principal> Authenticate(const HttpRequest& request) = 0;
};

class Authorizer {
 public:
  virtual ~Authorizer() = default;
  /// kForbidden with a sentence when the role lacks the permission.
  virtual core::Status MayUse(const Principal& who, Permission permission) const = 0;
  /// May `who` see or change something that belongs to principal `owner_id`? kNotFound when it
  /// must look absent.
  virtual core::Status MayTouch(const Principal& who,
                                std::string_view owner_id,
                                bool change) const = 0;
};

}  // namespace faultlab::server
