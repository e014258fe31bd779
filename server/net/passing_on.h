#pragma once

#include <boost/asio/awaitable.hpp>
#include <string>

#include "server/net/connection_host.h"

namespace faultlab::server {

/// The value of kHopHeader for `request` on its way to `peer`. Contract: the host has a seal.
std::string SealedHop(const ConnectionHost& host,
                      const HttpRequest& request,
                      const PeerAddress& peer);

/// Too many wait for this peer.
core::Error PeerFull(const PeerAddress& peer);

/// The answer of other servers to a request of a client. No thread waits: a peer that is silent
/// costs its callers their time and nobody else's. A caller who has its part of what may wait for a
/// peer gets 429, of a list as well. `request`, `ask` and `caller` outlive it.
boost::asio::awaitable<HttpResponse> PassOn(ConnectionHost& host,
                                            const HttpRequest& request,
                                            const AskPeers& ask,
                                            const std::string& caller);

}  // namespace faultlab::server
