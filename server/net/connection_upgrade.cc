// How a connection becomes a WebSocket of this server, or through it of another one.
#include <atomic>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
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

/// The place of one open tunnel.
class TunnelPlace {
 public:
  explicit TunnelPlace(std::atomic<std::uint64_t>& open) : open_(open) { ++open_; }
  ~TunnelPlace() { --open_; }
  TunnelPlace(const TunnelPlace&) = delete;
  TunnelPlace& operator=(const TunnelPlace&) = delete;

 private:
  std::atomic<std::uint64_t>& open_;
};

}  // namespace

asio::awaitable<bool> Connection::SwitchProtocols() {
  const std::string answer =
      "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Accept: " +
      websocket::AcceptKey(request_.Header("Sec-WebSocket-Key")) + "\r\n\r\n";
  co_return co_await sender_.Send(answer);
}

/// The refusal if there is no room for one more tunnel, or for one more of this client.
std::optional<HttpResponse> Connection::TunnelRefusal() const {
  const std::size_t max = host_.options.limits.peers.tunnels_max;
  if (!host_.seal || host_.counters.tunnels >= max) {
    return TryAgain(503, "Too many are watching; try again in a minute.", kTunnelsFullS);
  }
  if (host_.tunnels_of_client.Of(caller_) < (max + 1) / 2) return std::nullopt;
  return TryAgain(
      429, "Too many windows of your address are open; close some of them.", kTunnelsFullS);
}

/// The handshake with the peer comes first; then bytes are copied in both directions. The peer
/// pings its viewers, so silence means that the connection is dead. Only the peer can check the
/// code; until it has accepted it, the client has a place among the handshakes and none among the
/// tunnels.
asio::awaitable<Connection::Next> Connection::TunnelTo(const PeerAddress& peer) {
  const auto& limits = host_.options.limits;
  std::optional<HttpResponse> full = TunnelRefusal();
  if (!full) {
    const PeerLines::Room room = host_.handshakes_with_peer.RoomFor(peer.address, caller_);
    if (room == PeerLines::Room::kFull) full = PeerProblem(PeerFull(peer));
    if (room == PeerLines::Room::kCallerFull) full = CallerFullProblem();
  }
  if (full) {
    co_await Refuse(std::move(*full));
    co_return Next::kClose;
  }
  std::optional<PeerLines::Place> waiting(host_.handshakes_with_peer.Take(peer.address, caller_));
  deadline_ = std::chrono::steady_clock::time_point::max();  // the exchange has its own deadline
  PeerExchange exchange(host_.io, limits.peers, peer);
  const std::string hop = SealedHop(host_, request_, peer);
  auto answer = co_await exchange.Ask(request_, hop);
  waiting.reset();
  if (!answer || answer.value().status != 101) {
    if (!answer) ++host_.counters.peers_silent;
    HttpResponse refusal = answer ? std::move(answer).value() : PeerProblem(answer.error());
    co_await Refuse(std::move(refusal));
    co_return Next::kClose;
  }
  if (auto late = TunnelRefusal()) {  // other tunnels may have opened meanwhile
    co_await Refuse(std::move(*late));
    co_return Next::kClose;
  }
  const TunnelPlace place(host_.counters.tunnels);
  const ClientCounts::Place of_client = host_.tunnels_of_client.Take(caller_);
  const std::string early = exchange.pending();
  const std::string ahead(static_cast<const char*>(buffer_.data().data()), buffer_.size());
  error_code ec;
  idle_ = true;  // from here on, stopping the server loses nothing
  tunnel_ = true;
  if (!co_await SwitchProtocols() || !co_await sender_.Send(early)) co_return Next::kClose;
  co_await asio::async_write(
      exchange.socket(), asio::buffer(ahead), asio::redirect_error(asio::use_awaitable, ec));
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
