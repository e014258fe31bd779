#include "server/net/listen_address.h"

#include <arpa/inet.h>

#include <algorithm>
#include <charconv>

namespace faultlab::server {
namespace {

core::Error BadAddress(std::string_view text) {
  return {core::ErrorCode::kInvalid,
          "'" + std::string(text) +
              "' is not an address to listen on: write HOST:PORT, for example 127.0.0.1:8080",
          "listen"};
}

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

bool IsPort(std::string_view text) {
  constexpr std::size_t kDigitsMax = 5;
  return !text.empty() && text.size() <= kDigitsMax && std::ranges::all_of(text, IsDigit);
}

bool IsNameLetter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || IsDigit(c) || c == '-' || c == '.' ||
         c == '_';
}

}  // namespace

bool IsIpLiteral(std::string_view host) {
  const std::string text(host);
  in6_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1 ||
         inet_pton(AF_INET6, text.c_str(), &address) == 1;
}

bool IsLoopbackHost(std::string_view host) {
  if (host == "localhost" || host == "::1") return true;
  const std::string text(host);
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1 && (ntohl(address.s_addr) >> 24) == 127;
}

core::Result<ListenAddress> ParseListenAddress(std::string_view text) {
  std::string_view host = "127.0.0.1";
  std::string_view port = text;
  if (const std::size_t colon = text.rfind(':'); colon != std::string_view::npos) {
    host = text.substr(0, colon);
    port = text.substr(colon + 1);
    if (host.empty()) host = "0.0.0.0";
    if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
      host = host.substr(1, host.size() - 2);
    }
    if (host == "localhost") host = "127.0.0.1";
  }
  ListenAddress address;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), address.port);
  if (error != std::errc() || end != port.data() + port.size() || !IsIpLiteral(host)) {
    return BadAddress(text);
  }
  address.host = std::string(host);
  return address;
}

bool IsEveryHost(std::string_view host) {
  return host == "0.0.0.0" || host == "::";
}

std::optional<std::string_view> HostName(std::string_view host_header) {
  const bool bracketed = host_header.starts_with('[');
  const std::size_t end = bracketed ? host_header.find(']') : host_header.find(':');
  if (bracketed && end == std::string_view::npos) return std::nullopt;
  const std::string_view name =
      bracketed ? host_header.substr(1, end - 1) : host_header.substr(0, end);
  const std::size_t behind = bracketed ? end + 1 : name.size();
  const std::string_view port = host_header.substr(behind);
  if (!port.empty() && (port.front() != ':' || !IsPort(port.substr(1)))) return std::nullopt;
  if (bracketed) {
    const bool v6 = name.find(':') != std::string_view::npos && IsIpLiteral(name);
    return v6 ? std::optional(name) : std::nullopt;
  }
  if (name.empty() && !port.empty()) return std::nullopt;
  return std::ranges::all_of(name, IsNameLetter) ? std::optional(name) : std::nullopt;
}

bool HostAllowed(std::string_view host_header,
                 const std::vector<std::string>& allowed_hosts,
                 bool listener_on_loopback) {
  const auto name = HostName(host_header);
  if (!name) return false;
  if (*name == "localhost" || IsIpLiteral(*name)) return true;
  if (allowed_hosts.empty()) return !listener_on_loopback;
  return std::ranges::find(allowed_hosts, *name) != allowed_hosts.end();
}

bool OriginAllowed(std::string_view origin_header, std::string_view host_header) {
  if (origin_header.empty()) return true;
  const std::size_t scheme = origin_header.find("://");
  return scheme != std::string_view::npos && origin_header.substr(scheme + 3) == host_header;
}

}  // namespace faultlab::server
