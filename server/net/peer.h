#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/net/http.h"
#include "server/net/peer_address.h"
#include "server/net/peer_limits.h"

namespace faultlab::server {

/// One request to another server, on a connection of its own, as a coroutine of the network thread.
/// Whatever the peer does, it ends by its deadlines.
class PeerExchange {
 public:
  PeerExchange(boost::asio::io_context& io, const PeerLimits& limits, const PeerAddress& peer);

  /// Sends `request` as it came: method (HEAD as GET), target, body, and of the headers those that
  /// a handler reads. `hop` is the value of kHopHeader. The error is a sentence for the client, and
  /// says whether the request may have changed something.
  /// An answer 101 leaves the connection open: then socket() and pending() are the WebSocket's.
  boost::asio::awaitable<core::Result<HttpResponse>> Ask(const HttpRequest& request,
                                                         std::string_view hop);

  boost::asio::ip::tcp::socket& socket() { return *socket_; }
  /// Bytes of the peer behind its answer 101.
  std::string pending() const;

 private:
  class Deadline;
  boost::asio::awaitable<core::Status> Connect();
  boost::asio::awaitable<core::Result<HttpResponse>> ReadAnswer(const core::Error& silence);
  core::Error Unreachable() const;

  boost::asio::io_context& io_;
  const PeerLimits limits_;
  const PeerAddress& peer_;
  std::shared_ptr<boost::asio::ip::tcp::socket> socket_;  ///< its deadlines hold it as well
  boost::beast::flat_buffer buffer_;
};

/// Bytes both ways between a client and a peer until one of them ends, in fixed buffers: who does
/// not read is not read from. `heard` is called for each piece that the peer sends, `ending` once
/// when one side has closed.
boost::asio::awaitable<void> Tunnel(boost::asio::ip::tcp::socket& client,
                                    boost::asio::ip::tcp::socket& peer,
                                    std::function<void()> heard,
                                    std::function<void()> ending);

}  // namespace faultlab::server
