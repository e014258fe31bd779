#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::server {

struct ListenAddress {
  std::string host;  ///< IP literal without brackets
  std::uint16_t port = 0;
};

/// "127.0.0.1:8080", "[::1]:0", "0.0.0.0:80", "localhost:8080", ":8080" (every address), "8080"
/// (loopback).
core::Result<ListenAddress> ParseListenAddress(std::string_view text);

/// True for 127.0.0.0/8, ::1 and "localhost".
bool IsLoopbackHost(std::string_view host);
/// True for IPv4 and (bracketless) IPv6 literals.
bool IsIpLiteral(std::string_view host);

/// True for 0.0.0.0 and ::, which one listens on and does not connect to.
bool IsEveryHost(std::string_view host);

/// The name part of a Host header, without port and brackets; nothing unless the header is a name
/// or an IP literal and a port of digits at most. An absent header has an empty name.
std::optional<std::string_view> HostName(std::string_view host_header);

/// Whether a request with this Host may be served. A page of another site that points its own name
/// at this machine (DNS rebinding) carries that name: only literals, "localhost" and configured
/// names pass. With no names configured and a public listener every name passes. What is no name
/// never does: it would come back in links that are made of it.
bool HostAllowed(std::string_view host_header,
                 const std::vector<std::string>& allowed_hosts,
                 bool listener_on_loopback);

/// Whether a request that changes something, or a WebSocket, may come from this Origin: absent (not
/// a browser) or the same host and port as the Host header.
bool OriginAllowed(std::string_view origin_header, std::string_view host_header);

}  // namespace faultlab::server
