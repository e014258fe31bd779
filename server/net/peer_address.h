#pragma once

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "core/types/result.h"
#include "server/net/http.h"

namespace faultlab::server {

/// Another server of the same lab.
struct PeerAddress {
  std::string name;     ///< name in messages
  std::string address;  ///< "10.0.0.2:8080"; empty if unknown
};

/// The request is passed on to other servers, unchanged.
struct AskPeers {
  std::vector<PeerAddress> peers;
  /// Makes one answer of the peers' answers, in the order of `peers`; on the pool. Empty: there is
  /// one peer, and its answer is used.
  std::function<HttpResponse(std::vector<core::Result<HttpResponse>>)> join{};
  std::string caller{};  ///< whose places are counted; empty: the address
};

/// The result of a handler: an answer, or the servers that have it.
using RouteAnswer = std::variant<HttpResponse, AskPeers>;

}  // namespace faultlab::server
