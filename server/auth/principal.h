#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace faultlab::server {

enum class Role : std::uint8_t { kGuest, kStudent, kInstructor, kOperator, kAdmin, kService };
inline constexpr int kRoleCount = 6;
/// By Role.
inline constexpr std::array<std::string_view, kRoleCount> kRoleNames = {
    "guest", "student", "instructor", "operator", "admin", "service"};
/// "guest", "student", "instructor", "operator", "admin", "service".
std::string_view Name(Role role);
std::optional<Role> ParseRole(std::string_view name);

/// How the caller was authenticated.
enum class Proof : std::uint8_t { kNone, kSessionCookie, kApiKey };

/// The caller of a request. A plain value: made once per request by Accounts::Authenticate, passed
/// along.
struct Principal {
  std::int64_t user_id = 0;  ///< 0 for the guest
  std::string login = "guest";
  std::string name = "guest";  ///< as shown to others
  Role role = Role::kGuest;
  Proof proof = Proof::kNone;
  std::int64_t api_key_id = 0;       ///< > 0 when proof is kApiKey
  std::set<std::string> scopes;      ///< of the API key, see kScopes
  Role account_role = Role::kGuest;  ///< of the key's account now; `role` is kService then
  std::string csrf_token;            ///< the page gets it by GET auth/me; empty for keys
  std::string session_token_hash;    ///< identifies the sign-in for logout; empty for keys

  std::string address_key{};  ///< AddressKey of the client

  /// The unit by which requests, runs and bytes are counted: an account, or all guests of an
  /// address.
  std::string caller_key() const;
  /// Stored as `owner` of runs and other objects: "guest", "user:7". A key has its user as owner.
  std::string owner_key() const;
  bool signed_in() const { return user_id != 0; }
};

}  // namespace faultlab::server
