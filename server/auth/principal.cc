#include "server/auth/principal.h"

#include "server/storage/owner_key.h"

namespace faultlab::server {

std::string_view Name(Role role) {
  return kRoleNames[static_cast<std::size_t>(role)];
}

std::optional<Role> ParseRole(std::string_view name) {
  for (std::size_t i = 0; i < kRoleNames.size(); ++i) {
    if (kRoleNames[i] == name) return static_cast<Role>(i);
  }
  return std::nullopt;
}

std::string Principal::caller_key() const {
  return signed_in() ? owner_key() : "guest " + address_key;
}

std::string Principal::owner_key() const {
  return signed_in() ? OwnerKeyOf(user_id) : "guest";
}

}  // namespace faultlab::server
