#pragma once

#include <boost/asio/awaitable.hpp>

#include "server/net/connection_host.h"

namespace faultlab::server {

/// Asks a route, on the pool, whether the request may come in; as long as it says "not yet", again
/// every half second for half a minute. In between no thread waits. Contract: the route has
/// `admit`.
boost::asio::awaitable<Admission> AskAdmission(ConnectionHost& host,
                                               const Route& route,
                                               const HttpRequest& request);

}  // namespace faultlab::server
