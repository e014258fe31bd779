#pragma once

#include <boost/asio/awaitable.hpp>
#include <string>

#include "server/net/connection_host.h"

namespace faultlab::server {

/// The value of kHopHeader for `request` on its way to `peer`. Contract: the host has a seal.
std::string SealedHop(const ConnectionHost& host,
                      const HttpRequest& request,
                      const PeerAddress& peer);

/// The answer of other servers to a request of a client. No thread waits: a peer that is silent
/// costs its callers their time and nobody else's. `request` and `ask` outlive it.
boost::asio::awaitable<HttpResponse> PassOn(ConnectionHost& host,
                                            const HttpRequest& request,
                                            const AskPeers& ask);

}  // namespace faultlab::server
