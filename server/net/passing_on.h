#pragma once

#include <boost/asio/awaitable.hpp>
#include <string>

#include "server/net/connection_host.h"

namespace faultlab::server {

/// The value of kHopHeader for `request` to `peer`. Contract: the host has a seal.
std::string SealedHop(const ConnectionHost& host,
                      const HttpRequest& request,
                      const PeerAddress& peer);

/// Too many requests wait for this peer.
core::Error PeerFull(const PeerAddress& peer);

/// Gets the answer of other servers to a client's request. No thread waits: a silent peer delays
/// only its own callers. A caller whose share of the places at a peer is full gets 429, also for a
/// list. `request`, `ask` and `caller` must outlive it.
boost::asio::awaitable<HttpResponse> PassOn(ConnectionHost& host,
                                            const HttpRequest& request,
                                            const AskPeers& ask,
                                            const std::string& caller);

}  // namespace faultlab::server
