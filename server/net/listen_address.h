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

/// True for 0.0.0.0 and ::, on which a server can listen but to which a client cannot connect.
bool IsEveryHost(std::string_view host);

/// The name part of a Host header, without port and brackets; nothing unless the header is a name
/// or an IP literal, with or without a port of digits. An absent header has an empty name.
std::optional<std::string_view> HostName(std::string_view host_header);

/// Whether a request with this Host may be served. If a page of another site points its own name at
/// this machine (DNS rebinding), its requests carry that name; therefore only literals, "localhost"
/// and configured names pass. If no names are configured and the listener is public, every name
/// passes. Text that is not a name never passes, because links made from it would contain it.
bool HostAllowed(std::string_view host_header,
                 const std::vector<std::string>& allowed_hosts,
                 bool listener_on_loopback);

/// Whether a request that changes something, or a WebSocket, may come from this Origin: it is
/// absent (not a browser), or has the same host and port as the Host header.
bool OriginAllowed(std::string_view origin_header, std::string_view host_header);

}  // namespace faultlab::server
