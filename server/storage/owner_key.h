#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace faultlab::server {

/// How rows name an account whose is what they hold: "user:7".
inline constexpr std::string_view kUserKey = "user:";

/// Lines of the audit log whose details are lists of such keys: "user:7, user:8". In SQL.
inline constexpr std::string_view kVerbsOfLists = "'enrol', 'invite', 'take_back', 'class_links'";

inline std::string OwnerKeyOf(std::int64_t account) {
  return std::string(kUserKey) + std::to_string(account);
}

/// Nothing for a guest, or for what is no such key.
inline std::optional<std::int64_t> AccountOfOwner(std::string_view owner_key) {
  if (!owner_key.starts_with(kUserKey)) return std::nullopt;
  owner_key.remove_prefix(kUserKey.size());
  std::int64_t id = 0;
  const char* const last = owner_key.data() + owner_key.size();
  const auto [end, error] = std::from_chars(owner_key.data(), last, id);
  return error == std::errc() && end == last ? std::optional(id) : std::nullopt;
}

}  // namespace faultlab::server
