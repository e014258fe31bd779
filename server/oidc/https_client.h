#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"

namespace faultlab::server::oidc {

struct WebAnswer {
  int status = 0;
  std::string body;
};

struct WebRequest {
  std::string url;
  std::vector<std::string> headers;  ///< "Name: value"
  std::string form{};                ///< sent by POST when not empty; else GET
};

/// Sends requests to external servers, by https only, without following redirects. Blocks for up to
/// `deadline`: on pool threads only. Thread-safe.
class HttpsClient {
 public:
  struct Options {
    std::string ca_file;             ///< PEM; empty: the system's
    bool insecure_loopback = false;  ///< http://127.0.0.1, for tests with a provider beside them
    std::chrono::milliseconds connect_deadline{3'000};
    std::chrono::milliseconds deadline{5'000};
    std::size_t bytes_max = 256 << 10;
  };
  explicit HttpsClient(Options options);

  /// Whether a request to this address is allowed. kInvalid with the reason if not.
  core::Status CheckUrl(const std::string& url) const;
  /// An answer with any status is a result. kUnavailable, with libcurl's message, if there is no
  /// answer.
  core::Result<WebAnswer> Ask(const WebRequest& request) const;

 private:
  const Options options_;
};

/// Encodes a value for a query or a form.
std::string FormEncode(std::string_view text);

}  // namespace faultlab::server::oidc
