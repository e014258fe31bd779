#include "server/auth/principal.h"

#include <charconv>

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
  return signed_in() ? "user:" + std::to_string(user_id) : "guest";
}

std::optional<std::int64_t> AccountOfOwner(std::string_view owner_key) {
  constexpr std::string_view kUser = "user:";
  if (!owner_key.starts_with(kUser)) return std::nullopt;
  owner_key.remove_prefix(kUser.size());
  std::int64_t id = 0;
  const char* const last = owner_key.data() + owner_key.size();
  const auto [end, error] = std::from_chars(owner_key.data(), last, id);
  return error == std::errc() && end == last ? std::optional(id) : std::nullopt;
}

}  // namespace faultlab::server
