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

/// One request to another server, on its own connection, as a coroutine of the network thread. Its
/// deadlines end it whatever the peer does.
class PeerExchange {
 public:
  PeerExchange(boost::asio::io_context& io, const PeerLimits& limits, const PeerAddress& peer);

  /// Sends `request` as it came: method (HEAD as GET), target, body, and those headers that a
  /// handler reads. `hop` is the value of kHopHeader. The error is a sentence for the client and
  /// states whether the request may have changed something. After an answer 101 the connection
  /// stays open: socket() and pending() are then the WebSocket's.
  boost::asio::awaitable<core::Result<HttpResponse>> Ask(const HttpRequest& request,
                                                         std::string_view hop);

  boost::asio::ip::tcp::socket& socket() { return *socket_; }
  /// Bytes that the peer sent after its answer 101.
  std::string pending() const;

 private:
  class Deadline;
  boost::asio::awaitable<core::Status> Connect();
  boost::asio::awaitable<core::Result<HttpResponse>> ReadAnswer(const core::Error& silence);
  core::Error Unreachable() const;

  boost::asio::io_context& io_;
  const PeerLimits limits_;
  const PeerAddress& peer_;
  std::shared_ptr<boost::asio::ip::tcp::socket> socket_;  ///< its deadlines share it
  boost::beast::flat_buffer buffer_;
};

/// Copies bytes in both directions between a client and a peer until one of them ends, in fixed
/// buffers: if one side does not read, the other is not read from. `heard` is called for each piece
/// from the peer, `ending` once when one side has closed.
boost::asio::awaitable<void> Tunnel(boost::asio::ip::tcp::socket& client,
                                    boost::asio::ip::tcp::socket& peer,
                                    std::function<void()> heard,
                                    std::function<void()> ending);

}  // namespace faultlab::server
