#include "server/net/response_head.h"

namespace faultlab::server {
namespace {

constexpr std::string_view kPolicyName = "Content-Security-Policy";
constexpr std::string_view kPolicy =
    "Content-Security-Policy: default-src 'self'; object-src 'none'; "
    "base-uri 'none'; form-action 'self'; frame-ancestors 'none'\r\n";
constexpr std::string_view kSecurityHeaders =
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Opener-Policy: same-origin\r\n"
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
  bool cache_named = false;
  bool policy_named = false;
  for (const auto& [name, value] : response.headers) {
    head.append(name).append(": ").append(value).append("\r\n");
    cache_named = cache_named || name == "Cache-Control";
    policy_named = policy_named || name == kPolicyName;
  }
  if (!policy_named) head.append(kPolicy);
  if (!cache_named) head.append("Cache-Control: no-store\r\n");
  if (!keep_alive) head.append("Connection: close\r\n");
  head.append("\r\n");
  if (with_payload) head.append(payload);
  return head;
}

}  // namespace faultlab::server
