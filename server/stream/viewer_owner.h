#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace faultlab::server {

/// The person for whom a viewer was opened, and the right by which it was opened: when the sign-in
/// or the key ends, the viewer ends.
struct ViewerOwner {
  std::string caller{};         ///< Principal::caller_key(), by which viewers are counted
  std::int64_t account_id = 0;  ///< 0: a guest
  std::string sign_in{};        ///< Principal::session_token_hash; empty for a key
  std::int64_t api_key_id = 0;
  std::string role{};       ///< of the account at that time
  std::string run_owner{};  ///< owner of the run, if it belongs to somebody else; otherwise empty
  std::int64_t run_made_ms = 0;

  bool guest() const { return account_id == 0; }
  bool foreign() const { return !run_owner.empty(); }
  auto operator<=>(const ViewerOwner&) const = default;
};

}  // namespace faultlab::server
