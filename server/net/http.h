#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/types/result.h"
#include "server/spool.h"

namespace faultlab::server {

enum class HttpMethod : std::uint8_t { kGet, kHead, kPost, kPut, kPatch, kDelete, kOther };

std::string_view Name(HttpMethod method);

/// Equal when the case of ASCII letters is ignored: for names of headers.
bool EqualNoCase(std::string_view a, std::string_view b);

/// A complete request, as passed to a handler. Every view is valid until the handler returns.
struct HttpRequest {
  HttpMethod method = HttpMethod::kGet;
  std::string_view target;  ///< as sent: "/api/v1/runs?limit=5"
  std::string_view path;    ///< target up to '?'
  std::string_view query;   ///< target after '?', still encoded
  std::vector<std::pair<std::string_view, std::string_view>> headers;
  std::string_view body;
  /// The client: the peer, or the last X-Forwarded-For entry when the peer is a trusted proxy.
  std::string_view remote_address;
  bool https = false;  ///< X-Forwarded-Proto of a trusted proxy
  /// Another server of the lab passed the request on, with a valid seal; the client is the one that
  /// server stated.
  bool from_peer = false;
  /// The values of the {names} of the pattern, in order, percent-decoded.
  std::vector<std::pair<std::string_view, std::string>> path_parameters;

  /// Value of a header, in any case of `name`; empty if absent.
  std::string_view Header(std::string_view name) const;
  /// First value of a query parameter, decoded ("+" is a space). nullopt if absent.
  std::optional<std::string> Query(std::string_view name) const;
  /// Every query parameter, decoded, in order.
  std::vector<std::pair<std::string, std::string>> QueryAll() const;
  /// Value of {name} in the pattern. Contract: the pattern has it.
  const std::string& PathParameter(std::string_view name) const;
};

/// HttpResponse::patience between two servers.
inline constexpr std::string_view kPatienceHeader = "Faultlab-Patience";

struct HttpResponse {
  int status = 200;
  /// Static lifetime. Empty: the content type is among the headers.
  std::string_view content_type = "application/json";
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  /// Sent instead of `body` when not empty: bytes that live as long as the process.
  std::string_view static_body;
  /// Sent instead of either when set: piece by piece, so that it is never completely in memory.
  std::shared_ptr<const Spool> spool{};
  /// What the caller waits for has not come: the same is asked again, for so long, and the last
  /// answer is sent. 0: this one is sent.
  std::chrono::seconds patience{0};
  bool unsettled = false;  ///< what it tells of has not ended

  std::string_view payload() const {
    return static_body.empty() ? std::string_view(body) : static_body;
  }
  std::uint64_t payload_size() const { return spool ? spool->size() : payload().size(); }
};

/// RFC 9457 problem+json. `type` becomes "/problems/<type>", a stable word per kind of refusal, and
/// the `reason`.
HttpResponse Problem(int status,
                     std::string_view type,
                     std::string_view title,
                     std::string_view detail,
                     std::string_view field = {});

/// The same with the error's reason and parameters; an error without one gives its kind.
HttpResponse Problem(int status, const core::Error& error);

/// A temporary refusal: 429 or 503 with Retry-After.
HttpResponse TryAgain(int status, std::string_view detail, int seconds);

std::string_view ReasonPhrase(int status);

/// Decodes %XX; with `plus_is_space` also '+'. nullopt on a broken escape or a NUL.
std::optional<std::string> PercentDecode(std::string_view text, bool plus_is_space);
/// Appends `text` as a JSON string with its quotes; bytes that are not UTF-8 become U+FFFD.
void AppendJsonString(std::string& out, std::string_view text);
/// Adds ,"reason":"..","parameters":{..} to an open JSON object. The reason of an error without one
/// is its kind.
void AppendReason(std::string& out, const core::Error& error);

}  // namespace faultlab::server
