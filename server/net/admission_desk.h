#pragma once

#include <boost/asio/awaitable.hpp>
#include <optional>
#include <string>

#include "server/net/connection_host.h"

namespace faultlab::server {

/// Why a pool takes nothing of this caller now, counted; nothing when it does.
std::optional<HttpResponse> PoolRefusal(ConnectionHost& host,
                                        const HandlerPool& pool,
                                        const HandlerPool::Turn& turn);

/// Asks a route, on the pool, whether the request may come in; as long as it says "not yet", again
/// every half second for half a minute. In between no thread waits. Contract: the route has
/// `admit`. `caller` takes turns with others.
boost::asio::awaitable<Admission> AskAdmission(ConnectionHost& host,
                                               const Route& route,
                                               const HttpRequest& request,
                                               const std::string& caller);

}  // namespace faultlab::server
