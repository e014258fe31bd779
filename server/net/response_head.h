#pragma once

#include <string>
#include <string_view>

#include "server/net/http.h"

namespace faultlab::server {

/// Status line and headers of an answer, the security headers among them.
/// @param date          RFC 9110 date, already formatted
/// @param with_payload  the payload follows in the same string: one buffer, one send
std::string EncodeResponseHead(const HttpResponse& response,
                               std::string_view date,
                               bool keep_alive,
                               bool with_payload);

}  // namespace faultlab::server
