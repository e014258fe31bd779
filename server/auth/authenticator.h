#pragma once

#include <string_view>

#include "core/types/result.h"
#include "server/auth/principal.h"

namespace faultlab::server {

inline constexpr std::string_view kCsrfHeaderName = "X-CSRF-Token";

/// The parts of a request that identify the caller. Views into the request; empty = header absent.
struct RequestCredentials {
  std::string_view cookie;         ///< Cookie
  std::string_view authorization;  ///< Authorization: Bearer flk_..
  std::string_view csrf_token;     ///< X-CSRF-Token
  std::string_view origin;         ///< Origin
  std::string_view host;           ///< Host
  std::string_view
      remote_address;          ///< of the client; X-Forwarded-For only when the peer is loopback
  bool changes_state = false;  ///< method is neither GET nor HEAD
};

}  // namespace faultlab::server
