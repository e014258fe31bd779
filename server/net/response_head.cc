#include "server/net/response_head.h"

#include <algorithm>
#include <array>
#include <utility>

namespace faultlab::server {
namespace {

/// Of every answer that does not name its own.
constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kUsual = {{
    {"Content-Security-Policy",
     "default-src 'self'; object-src 'none'; base-uri 'none'; form-action 'self'; frame-ancestors "
     "'none'"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cache-Control", "no-store"},
}};
constexpr std::string_view kSecurityHeaders =
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n"
    "Permissions-Policy: camera=(), microphone=(), geolocation=()\r\n";

}  // namespace

std::string EncodeResponseHead(const HttpResponse& response,
                               std::string_view date,
                               bool keep_alive,
                               bool with_payload) {
  const std::string_view payload = response.payload();
  std::string head;
  head.reserve(900 + (with_payload ? payload.size() : 0));
  head.append("HTTP/1.1 ").append(std::to_string(response.status)).append(" ");
  head.append(ReasonPhrase(response.status)).append("\r\nServer: faultlab\r\nDate: ").append(date);
  if (response.status != 304 && response.status != 204) {
    if (!response.content_type.empty()) {
      head.append("\r\nContent-Type: ").append(response.content_type);
    }
    head.append("\r\nContent-Length: ").append(std::to_string(response.payload_size()));
  }
  head.append("\r\n").append(kSecurityHeaders);
  for (const auto& [name, value] : response.headers) {
    head.append(name).append(": ").append(value).append("\r\n");
  }
  for (const auto& usual : kUsual) {
    const bool named = std::ranges::any_of(
        response.headers, [&](const auto& header) { return header.first == usual.first; });
    if (!named) head.append(usual.first).append(": ").append(usual.second).append("\r\n");
  }
  if (!keep_alive) head.append("Connection: close\r\n");
  head.append("\r\n");
  if (with_payload) head.append(payload);
  return head;
}

}  // namespace faultlab::server
