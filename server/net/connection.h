#pragma once

#include <array>
#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "server/net/byte_budget.h"
#include "server/net/http_server.h"

namespace faultlab::server {

class Connection;

/// What the connections of one server share. Only the atomics may be read off the network thread.
struct ConnectionHost {
  struct Counters {
    std::atomic<std::uint64_t> accepted{0}, refused{0}, open{0}, requests{0}, deadlines{0},
        pool_refused{0}, bytes_refused{0}, passed_on{0}, peers_silent{0}, tunnels{0};
    std::array<std::atomic<std::uint64_t>, 6> answers{};
  };

  HttpServerOptions options;
  const Router& router;
  std::function<UpgradeDecision(const HttpRequest&)> upgrade;
  bool on_loopback = false;
  std::optional<HopSeal> seal{};  ///< of the lab's servers; set before the threads start
  Counters counters{};
  std::atomic<std::size_t> pool_waiting{0};
  bool pool_closed = false;  ///< the server stops: of the network thread
  ByteBudget waiting_bytes{options.limits.waiting_bytes_max};
  std::unordered_set<Connection*> connections{};
  std::unordered_map<std::string, int> waiting_for_peer{};  ///< requests, by the peer's address
  std::chrono::steady_clock::time_point now{};              ///< coarse: moved twice a second
  std::string date{};                                       ///< of `now`, as answers carry it
  // Connections live in the coroutines that io owns: io goes first, what they touch stays above.
  std::optional<boost::asio::thread_pool> pool{};
  boost::asio::io_context io{1};

  void Report(std::string_view text) const {
    if (options.on_error) options.on_error(text);
  }
};

/// One connection: reads requests, has them handled, writes the answers. Lives in its own coroutine
/// on the network thread.
class Connection {
 public:
  Connection(ConnectionHost& host, boost::asio::ip::tcp::socket socket);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Until the peer leaves, a deadline passes, or the socket becomes a WebSocket.
  boost::asio::awaitable<void> Run();

  void CloseIfLate();
  /// The request at work is the last one; a connection that waits is closed at once.
  void CloseIfIdle();

 private:
  using Parser = boost::beast::http::request_parser<boost::beast::http::string_body>;
  enum class Next { kKeepAlive, kClose, kUpgraded };

  void Close();
  void Deadline(std::chrono::milliseconds from_now) { deadline_ = host_.now + from_now; }

  boost::asio::awaitable<bool> ReadMore(std::size_t bytes);
  boost::asio::awaitable<bool> ReadHeader();
  boost::asio::awaitable<bool> Admit(const Route& route);
  boost::asio::awaitable<bool> ReadBody(std::size_t bytes_max);
  bool HoldBody(std::size_t bytes);
  boost::asio::awaitable<Next> Serve();
  boost::asio::awaitable<Next> Upgrade();
  boost::asio::awaitable<Next> TunnelTo(const PeerAddress& peer);
  boost::asio::awaitable<bool> SwitchProtocols();
  boost::asio::awaitable<RouteAnswer> RunOnPool(const Route& route);
  boost::asio::awaitable<HttpResponse> PassOn(const AskPeers& ask);
  boost::asio::awaitable<core::Result<HttpResponse>> AskPeer(const PeerAddress& peer);
  std::string SealedHop(const PeerAddress& peer) const;
  template <typename Work>
  boost::asio::awaitable<std::invoke_result_t<Work&>> OnPool(Work work);
  bool PoolIsFull();
  boost::asio::awaitable<bool> Send(const HttpResponse& response, bool keep_alive);
  boost::asio::awaitable<bool> SendBytes(std::string_view bytes);
  boost::asio::awaitable<void> Refuse(HttpResponse response);
  void FillRequest();
  bool ReadHop();
  RouteAnswer Handle(const Route& route) const;

  ConnectionHost& host_;
  boost::asio::ip::tcp::socket socket_;
  boost::beast::flat_buffer buffer_;
  std::optional<Parser> parser_;
  HttpRequest request_;
  ByteBudget::Hold body_bytes_;     ///< of the request at work, as far as it has arrived
  std::shared_ptr<void> admitted_;  ///< of the request at work
  std::string peer_address_;
  std::string hop_client_;  ///< of the request at work, when another server passed it on
  std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::time_point::max();
  bool peer_is_loopback_ = false;
  bool reading_request_ = false;
  bool idle_ = false;
  bool last_request_ = false;
};

}  // namespace faultlab::server
