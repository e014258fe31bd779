// How a connection becomes a WebSocket: of this server, or through it of another one.
#include <atomic>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cstdint>
#include <utility>
#include <variant>

#include "server/net/connection.h"
#include "server/net/listen_address.h"
#include "server/net/passing_on.h"
#include "server/net/peer.h"
#include "server/net/refusals.h"
#include "server/net/websocket.h"

namespace faultlab::server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr int kTunnelsFullS = 60;

}  // namespace

asio::awaitable<bool> Connection::SwitchProtocols() {
  const std::string answer =
      "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Accept: " +
      websocket::AcceptKey(request_.Header("Sec-WebSocket-Key")) + "\r\n\r\n";
  co_return co_await sender_.Send(answer);
}

/// The peer shakes hands first; then the bytes go both ways as they come. Its viewers are pinged,
/// so silence means that it is gone.
asio::awaitable<Connection::Next> Connection::TunnelTo(const PeerAddress& peer) {
  const auto& limits = host_.options.limits;
  if (!host_.seal || host_.counters.tunnels >= limits.peers.tunnels_max) {
    co_await Refuse(TryAgain(503, "Too many are watching; try again in a minute.", kTunnelsFullS));
    co_return Next::kClose;
  }
  struct Place {
    explicit Place(std::atomic<std::uint64_t>& count) : taken(count) { ++taken; }
    ~Place() { --taken; }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;
    std::atomic<std::uint64_t>& taken;
  };
  std::optional<Place> place(host_.counters.tunnels);
  deadline_ = std::chrono::steady_clock::time_point::max();  // the exchange has its own
  PeerExchange exchange(host_.io, limits.peers, peer);
  const std::string hop = SealedHop(host_, request_, peer);
  auto answer = co_await exchange.Ask(request_, hop);
  if (!answer || answer.value().status != 101) {
    if (!answer) ++host_.counters.peers_silent;
    place.reset();
    HttpResponse refusal = answer ? std::move(answer).value() : PeerProblem(answer.error());
    co_await Refuse(std::move(refusal));
    co_return Next::kClose;
  }
  const std::string early = exchange.pending();
  const std::string late(static_cast<const char*>(buffer_.data().data()), buffer_.size());
  error_code ec;
  idle_ = true;  // from here on nothing is lost when the server stops
  tunnel_ = true;
  if (!co_await SwitchProtocols() || !co_await sender_.Send(early)) co_return Next::kClose;
  co_await asio::async_write(
      exchange.socket(), asio::buffer(late), asio::redirect_error(asio::use_awaitable, ec));
  ++host_.counters.answers[1];
  Deadline(limits.peers.tunnel_silence);
  bool ended = false;
  co_await Tunnel(
      socket_,
      exchange.socket(),
      [&] {
        if (!ended) Deadline(limits.peers.tunnel_silence);
      },
      [&] {
        ended = true;
        Deadline(kLinger);
      });
  co_return Next::kUpgraded;
}

asio::awaitable<Connection::Next> Connection::Upgrade() {
  const auto refuse = [this](HttpResponse response) -> asio::awaitable<Next> {
    co_await Refuse(std::move(response));
    co_return Next::kClose;
  };
  if (request_.Header("Sec-WebSocket-Version") != "13") {
    HttpResponse response =
        Problem(426, "upgrade_required", "Wrong version", "Only WebSocket version 13 is spoken.");
    response.headers.emplace_back("Sec-WebSocket-Version", "13");
    co_return co_await refuse(std::move(response));
  }
  const std::string_view key = request_.Header("Sec-WebSocket-Key");
  if (!websocket::IsValidKey(key) || request_.method != HttpMethod::kGet) {
    co_return co_await refuse(Problem(
        400, "bad_handshake", "Bad handshake", "Sec-WebSocket-Key is not 16 bytes in base64."));
  }
  if (!OriginAllowed(request_.Header("Origin"), request_.Header("Host"))) {
    co_return co_await refuse(Problem(
        403, "foreign_origin", "Foreign origin", "A page of another site may not connect here."));
  }
  UpgradeDecision decision = host_.upgrade(request_);
  if (auto* refusal = std::get_if<HttpResponse>(&decision)) {
    co_return co_await refuse(std::move(*refusal));
  }
  if (const auto* peer = std::get_if<PeerAddress>(&decision)) co_return co_await TunnelTo(*peer);
  if (!co_await SwitchProtocols()) co_return Next::kClose;
  UpgradedSocket upgraded;
  upgraded.pending.assign(static_cast<const char*>(buffer_.data().data()), buffer_.size());
  error_code ec;
  upgraded.fd = socket_.release(ec);
  if (ec) co_return Next::kClose;
  ++host_.counters.answers[1];
  std::get<1>(decision)(std::move(upgraded));
  co_return Next::kUpgraded;
}

}  // namespace faultlab::server
