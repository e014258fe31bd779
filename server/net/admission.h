#pragma once

#include <boost/asio/awaitable.hpp>
#include <optional>
#include <string>

#include "server/net/connection_host.h"

namespace faultlab::server {

/// The refusal, counted, if a pool accepts no work of this caller now; nothing if it does.
std::optional<HttpResponse> PoolRefusal(ConnectionHost& host,
                                        const HandlerPool& pool,
                                        const HandlerPool::Turn& turn);

/// Asks a route, on the pool, whether the request is permitted. While the answer is "not yet", it
/// asks again every half second for half a minute; no thread waits in between. Contract: the route
/// has `admit`. `caller` takes turns with others.
boost::asio::awaitable<Admission> AskAdmission(ConnectionHost& host,
                                               const Route& route,
                                               const HttpRequest& request,
                                               const std::string& caller);

}  // namespace faultlab::server
