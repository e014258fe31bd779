#include "server/web_client/web_client.h"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>

#include "core/types/check.h"

namespace faultlab::server {
namespace {

struct FreeUrl {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};
struct FreeCurl {
  void operator()(CURL* curl) const { curl_easy_cleanup(curl); }
};
struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
struct FreeText {
  void operator()(char* text) const { curl_free(text); }
};

void StartCurl() {
  static const CURLcode started = curl_global_init(CURL_GLOBAL_DEFAULT);
  LAB_CHECK(started == CURLE_OK);
}

std::string Part(CURLU* url, CURLUPart part) {
  char* text = nullptr;
  if (curl_url_get(url, part, &text, 0) != CURLUE_OK) return {};
  const std::unique_ptr<char, FreeText> held(text);
  return text;
}

bool IsLoopback(const std::string& host) {
  return host == "127.0.0.1" || host == "localhost" || host == "[::1]";
}

bool IsPrivate(const in_addr& address) {
  const std::uint32_t bits = ntohl(address.s_addr);
  return (bits >> 24U) == 127 || (bits >> 24U) == 10 || (bits >> 20U) == 0xAC1 ||
         (bits >> 16U) == 0xC0A8;
}

bool IsPrivate(const in6_addr& address) {
  return IN6_IS_ADDR_LOOPBACK(&address) || (address.s6_addr[0] & 0xFEU) == 0xFC;
}

/// What routers carry: none of RFC 6890's special purposes.
bool IsPublic(const in_addr& address) {
  const std::uint32_t bits = ntohl(address.s_addr);
  const bool shared = (bits >> 22U) == (0x64400000U >> 22U);      // 100.64.0.0/10
  const bool link_local = (bits >> 16U) == 0xA9FE;                // 169.254.0.0/16
  const bool protocols = (bits >> 8U) == 0xC00000;                // 192.0.0.0/24
  const bool benchmarks = (bits >> 17U) == (0xC6120000U >> 17U);  // 198.18.0.0/15
  return !IsPrivate(address) && (bits >> 24U) != 0 && !shared && !link_local && !protocols &&
         !benchmarks && (bits >> 28U) < 0xE;
}

bool IsPublic(const sockaddr& address, int family) {
  if (family == AF_INET) {
    sockaddr_in four{};
    std::memcpy(&four, &address, sizeof(four));
    return IsPublic(four.sin_addr);
  }
  if (family != AF_INET6) return false;
  sockaddr_in6 six{};
  std::memcpy(&six, &address, sizeof(six));
  // Global unicast is 2000::/3; in it are also tunnels that lead to an IPv4 address.
  const auto& bytes = six.sin6_addr.s6_addr;
  const bool global = (bytes[0] & 0xE0U) == 0x20;
  const bool tunnel = (bytes[0] == 0x20 && bytes[1] == 0x02) ||
                      (bytes[0] == 0x20 && bytes[1] == 0x01 && bytes[2] == 0 && bytes[3] == 0);
  return global && !tunnel;
}

/// Whether it is of a network of this machine, whose address may be a public one.
bool IsOfThisMachine(const sockaddr& address, int family) {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return true;
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> held(all, &freeifaddrs);
  const std::size_t at =
      family == AF_INET ? offsetof(sockaddr_in, sin_addr) : offsetof(sockaddr_in6, sin6_addr);
  const std::size_t bytes = family == AF_INET ? sizeof(in_addr) : sizeof(in6_addr);
  const auto* const to = reinterpret_cast<const unsigned char*>(&address) + at;
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    if (each->ifa_addr == nullptr || each->ifa_netmask == nullptr) continue;
    if (each->ifa_addr->sa_family != family) continue;
    const auto* const own = reinterpret_cast<const unsigned char*>(each->ifa_addr) + at;
    const auto* const mask = reinterpret_cast<const unsigned char*>(each->ifa_netmask) + at;
    bool same = true;
    for (std::size_t i = 0; i < bytes; ++i) same = same && (to[i] & mask[i]) == (own[i] & mask[i]);
    if (same) return true;
  }
  return false;
}

curl_socket_t OpenPublic(void*, curlsocktype, curl_sockaddr* to) {
  if (!IsPublic(to->addr, to->family)) return CURL_SOCKET_BAD;
  if (IsOfThisMachine(to->addr, to->family)) return CURL_SOCKET_BAD;
  return socket(to->family, to->socktype | SOCK_CLOEXEC, to->protocol);
}

struct Body {
  std::string text;
  std::size_t bytes_max = 0;
};

std::size_t Take(char* data, std::size_t size, std::size_t count, void* user) {
  Body& body = *static_cast<Body*>(user);
  const std::size_t bytes = size * count;
  if (body.text.size() + bytes > body.bytes_max) return 0;  // ends the transfer with an error
  body.text.append(data, bytes);
  return bytes;
}

core::Error Unavailable(const std::string& what) {
  return {core::ErrorCode::kUnavailable, what, ""};
}

}  // namespace

WebClient::WebClient(WebClientOptions options) : options_(std::move(options)) {
  StartCurl();
}

core::Status WebClient::CheckUrl(const std::string& url) const {
  const std::unique_ptr<CURLU, FreeUrl> parsed(curl_url());
  const bool readable =
      parsed && curl_url_set(parsed.get(), CURLUPART_URL, url.c_str(), 0) == CURLUE_OK;
  if (!readable) return core::Error{core::ErrorCode::kInvalid, "'" + url + "' is no address", ""};
  const std::string scheme = Part(parsed.get(), CURLUPART_SCHEME);
  const std::string host = Part(parsed.get(), CURLUPART_HOST);
  const bool near = (options_.insecure_loopback && IsLoopback(host)) ||
                    (options_.insecure_local && IsLocalHost(host));
  const bool allowed = scheme == "https" || (scheme == "http" && near);
  if (!allowed || !Part(parsed.get(), CURLUPART_USER).empty()) {
    return core::Error{core::ErrorCode::kInvalid, "'" + url + "' is not https", ""};
  }
  return core::Done{};
}

core::Result<WebAnswer> WebClient::Ask(const WebRequest& request) const {
  if (const core::Status good = CheckUrl(request.url); !good.ok()) return good.error();
  const std::unique_ptr<CURL, FreeCurl> curl(curl_easy_init());
  if (!curl) return Unavailable("no memory for a connection");
  std::unique_ptr<curl_slist, FreeList> headers;
  for (const std::string& header : request.headers) {
    curl_slist* longer = curl_slist_append(headers.get(), header.c_str());
    if (longer == nullptr) return Unavailable("no memory for a connection");
    (void)headers.release();
    headers.reset(longer);
  }
  const bool plain = request.url.starts_with("http:");
  Body body{{}, options_.bytes_max};
  std::string words(CURL_ERROR_SIZE, '\0');
  CURL* const to = curl.get();
  curl_easy_setopt(to, CURLOPT_URL, request.url.c_str());
  curl_easy_setopt(to, CURLOPT_PROTOCOLS_STR, plain ? "http" : "https");
  curl_easy_setopt(to, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(to, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(to, CURLOPT_SSLVERSION, static_cast<long>(CURL_SSLVERSION_TLSv1_2));
  curl_easy_setopt(to, CURLOPT_CONNECTTIMEOUT_MS, options_.connect_deadline.count());
  curl_easy_setopt(to, CURLOPT_TIMEOUT_MS, options_.deadline.count());
  curl_easy_setopt(to, CURLOPT_USERAGENT, "faultlab");
  curl_easy_setopt(to, CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(to, CURLOPT_ERRORBUFFER, words.data());
  curl_easy_setopt(to, CURLOPT_WRITEFUNCTION, Take);
  curl_easy_setopt(to, CURLOPT_WRITEDATA, &body);
  if (!options_.ca_file.empty()) curl_easy_setopt(to, CURLOPT_CAINFO, options_.ca_file.c_str());
  if (plain || request.public_only) curl_easy_setopt(to, CURLOPT_NOPROXY, "*");
  if (request.public_only) curl_easy_setopt(to, CURLOPT_OPENSOCKETFUNCTION, OpenPublic);
  if (!request.body.empty()) {
    curl_easy_setopt(to, CURLOPT_POSTFIELDSIZE, static_cast<long>(request.body.size()));
    curl_easy_setopt(to, CURLOPT_POSTFIELDS, request.body.c_str());
  }
  const CURLcode done = curl_easy_perform(to);
  if (done != CURLE_OK) {
    const std::string why = words.substr(0, words.find('\0'));
    if (done == CURLE_WRITE_ERROR) {
      return core::Error{core::ErrorCode::kTooLarge, request.url + ": its answer is too large", ""};
    }
    return Unavailable(request.url + ": " + (why.empty() ? curl_easy_strerror(done) : why));
  }
  long status = 0;
  curl_easy_getinfo(to, CURLINFO_RESPONSE_CODE, &status);
  WebAnswer answer{static_cast<int>(status), std::move(body.text)};
  curl_header* link = nullptr;
  for (std::size_t at = 0; curl_easy_header(to, "Link", at, CURLH_HEADER, -1, &link) == CURLHE_OK;
       ++at) {
    answer.link += (at > 0 ? ", " : "") + std::string(link->value);
  }
  return answer;
}

bool IsLocalHost(std::string_view host) {
  if (host == "localhost" || host.ends_with(".local")) return true;
  in_addr four{};
  if (inet_pton(AF_INET, std::string(host).c_str(), &four) == 1) return IsPrivate(four);
  if (!host.starts_with('[') || !host.ends_with(']')) return false;
  const std::string inside(host.substr(1, host.size() - 2));
  in6_addr six{};
  return inet_pton(AF_INET6, inside.c_str(), &six) == 1 && IsPrivate(six);
}

std::string FormEncode(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '.' || c == '_' || c == '~';
    if (plain) {
      out.push_back(c);
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    out += '%';
    out += kDigits[byte >> 4U];
    out += kDigits[byte & 15U];
  }
  return out;
}

}  // namespace faultlab::server
