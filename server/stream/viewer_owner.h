#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace faultlab::server {

/// Whose window a viewer is, and by what right it is open: what was opened by a sign-in or a key
/// ends with it.
struct ViewerOwner {
  std::string caller{};         ///< Principal::caller_key(): whose windows are counted together
  std::int64_t account_id = 0;  ///< 0: a guest
  std::string sign_in{};        ///< Principal::session_token_hash; empty for a key
  std::int64_t api_key_id = 0;
  std::string role{};       ///< of the account when it was opened
  std::string run_owner{};  ///< of a run of somebody else: whose it is; empty for one's own
  std::int64_t run_made_ms = 0;

  bool guest() const { return account_id == 0; }
  bool foreign() const { return !run_owner.empty(); }
  auto operator<=>(const ViewerOwner&) const = default;
};

}  // namespace faultlab::server
