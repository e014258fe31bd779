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
  std::string name;     ///< as texts name it
  std::string address;  ///< "10.0.0.2:8080"; empty: it has said none
};

/// The request goes on to other servers, as it came.
struct AskPeers {
  std::vector<PeerAddress> peers;
  /// Makes one answer of theirs, in the order of `peers`; on the pool. Empty: there is one peer,
  /// and its answer is the answer.
  std::function<HttpResponse(std::vector<core::Result<HttpResponse>>)> join{};
  std::string caller{};  ///< with whom others share what may wait; empty: the client's address
};

/// What a handler says: the answer, or who has it.
using RouteAnswer = std::variant<HttpResponse, AskPeers>;

}  // namespace faultlab::server
