#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::server {

struct WebAnswer {
  int status = 0;
  std::string body;
  std::string link{};  ///< its headers Link (RFC 8288), joined by commas
};

struct WebRequest {
  std::string url;
  std::vector<std::string> headers;  ///< "Name: value"
  /// Sent by POST when not empty; else GET. A form, unless a header says Content-Type.
  std::string body{};
  /// To addresses of the internet alone, whatever the name means: not to this machine, its network,
  /// or by its proxy.
  bool public_only = false;
};

struct WebClientOptions {
  std::string ca_file{};           ///< PEM; empty: the system's
  bool insecure_loopback = false;  ///< http://127.0.0.1, for tests with a provider beside them
  bool insecure_local = false;     ///< http:// to loopback and the local network
  std::chrono::milliseconds connect_deadline{3'000};
  std::chrono::milliseconds deadline{5'000};
  std::size_t bytes_max = 256 << 10;
};

/// Sends requests to external servers, by https unless the options allow http, without following
/// redirects. Blocks for up to `deadline`: on pool threads only. Thread-safe.
class WebClient {
 public:
  explicit WebClient(WebClientOptions options);

  /// Whether a request to this address is allowed. kInvalid with the reason if not.
  core::Status CheckUrl(const std::string& url) const;
  /// An answer with any status is a result. kUnavailable, with libcurl's message, if there is no
  /// answer; kTooLarge if it has more than `bytes_max`.
  core::Result<WebAnswer> Ask(const WebRequest& request) const;

 private:
  const WebClientOptions options_;
};

/// Whether this host of an address is in the local network by its name alone: loopback, a private
/// IP address (RFC 1918, RFC 4193; IPv6 in brackets), or a name that ends in ".local".
bool IsLocalHost(std::string_view host);

/// Encodes a value for a query or a form.
std::string FormEncode(std::string_view text);

}  // namespace faultlab::server
