#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/net/byte_budget.h"
#include "server/net/client_counts.h"
#include "server/net/connection_host.h"
#include "server/net/paced_sender.h"

namespace faultlab::server {

/// One connection: reads requests, runs their handlers, writes the answers. Runs as its own
/// coroutine on the network thread.
class Connection {
 public:
  Connection(ConnectionHost& host, boost::asio::ip::tcp::socket socket);
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Runs until the peer leaves, a deadline passes, or the socket becomes a WebSocket.
  boost::asio::awaitable<void> Run();

  /// Closes the connection when its deadline has passed. Called twice a second.
  void Sweep();
  /// Between two requests, or two looks at what its client waits for: closing the connection loses
  /// nothing.
  bool idle() const { return idle_ && !tunnel_ && socket_.is_open(); }
  /// The server waits for the client: for the rest of a request, or until it receives the rest of
  /// an answer.
  bool waits_for_client() const { return slow_.taken() && socket_.is_open(); }
  /// The number of such connections of that client.
  std::size_t waiting_of_client() const { return slow_.of_client(); }
  /// The number of connections of the peer's address.
  std::size_t of_address() const { return place_.of_client(); }
  /// The time since which it has been idle or has waited for its client.
  std::chrono::steady_clock::time_point waits_since() const { return waits_since_; }
  void Close();
  /// Bytes of the budget held by the current request and its answer.
  std::size_t held_bytes() const { return body_bytes_.bytes() + answer_bytes_.bytes(); }
  /// The caller of the current request: an account, or an address.
  const std::string& caller() const { return caller_; }
  bool caller_is_known() const { return caller_is_known_; }
  /// Closes it and gives its bytes back at once.
  void GiveUp();
  /// The current request is the last one; a waiting connection is closed at once.
  void CloseIfIdle();

 private:
  using Parser = boost::beast::http::request_parser<boost::beast::http::string_body>;
  static constexpr std::size_t kSmallBytes = 64 << 10;  ///< what may wait without the budget
  enum class Next { kKeepAlive, kClose, kUpgraded };

  void Deadline(std::chrono::milliseconds from_now) { deadline_ = host_.now + from_now; }
  void WaitFor(const std::string& client);

  boost::asio::awaitable<bool> ReadMore(std::size_t bytes);
  boost::asio::awaitable<bool> ReadHeader();
  /// False when the request is refused and the connection ends.
  boost::asio::awaitable<bool> Admit(const Route& route);
  boost::asio::awaitable<bool> ReadBody(std::size_t bytes_max);
  bool HoldBody(std::size_t bytes);
  boost::asio::awaitable<Next> Serve();
  boost::asio::awaitable<Next> Upgrade();
  boost::asio::awaitable<Next> TunnelTo(const PeerAddress& peer);
  std::optional<HttpResponse> TunnelRefusal() const;
  boost::asio::awaitable<bool> SwitchProtocols();
  boost::asio::awaitable<HttpResponse> Answer(const Route& route);
  boost::asio::awaitable<HttpResponse> AnswerOnce(const Route& route);
  boost::asio::awaitable<void> Refuse(HttpResponse response);
  bool HasPeerClosedItsHalf();
  void FillRequest();
  std::string_view LastHeader(std::string_view name) const;
  bool ReadHop();
  bool HasBodyOfHop() const;
  RouteAnswer Handle(const Route& route) const;
  std::function<bool()> StillMay(const Route* route) const;

  ConnectionHost& host_;
  boost::asio::ip::tcp::socket socket_;
  boost::beast::flat_buffer buffer_;
  std::optional<Parser> parser_;
  HttpRequest request_;
  ByteBudget::Reservation body_bytes_;    ///< of the current request, as far as it has arrived
  ByteBudget::Reservation answer_bytes_;  ///< until the answer is completely sent
  std::shared_ptr<void> admitted_;        ///< of the current request
  std::string peer_address_;
  std::string address_key_;       ///< of the peer
  ClientCounts::Place place_;     ///< of `address_key_`
  ClientCounts::Place slow_;      ///< taken while waiting for the client
  std::string caller_;            ///< of the current request; callers take turns
  bool caller_is_known_ = false;  ///< has an account
  // Of the current request, if another server passed it on.
  std::string hop_client_;
  std::string hop_body_hash_;
  std::chrono::steady_clock::time_point deadline_ = std::chrono::steady_clock::time_point::max();
  PacedSender sender_;
  bool behind_proxy_ = false;  ///< the peer may state who the client is
  bool reading_request_ = false;
  bool idle_ = false;
  bool tunnel_ = false;
  std::chrono::steady_clock::time_point waits_since_{};
  bool last_request_ = false;
};

}  // namespace faultlab::server
