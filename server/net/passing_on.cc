#include "server/net/passing_on.h"

#include <utility>
#include <vector>

#include "server/clock.h"
#include "server/net/admission.h"
#include "server/net/peer.h"
#include "server/net/refusals.h"

namespace faultlab::server {
namespace {

namespace asio = boost::asio;

PeerLines& LineOf(ConnectionHost& host, const HttpRequest& request) {
  const bool reads = request.method == HttpMethod::kGet || request.method == HttpMethod::kHead;
  return reads ? host.reads_at_peer : host.changes_at_peer;
}

asio::awaitable<core::Result<HttpResponse>> AskPeer(ConnectionHost& host,
                                                    const HttpRequest& request,
                                                    const PeerAddress& peer,
                                                    const std::string& caller) {
  PeerLines& lines = LineOf(host, request);
  if (!host.seal || lines.RoomFor(peer.address, caller) != PeerLines::Room::kFree) {
    co_return PeerFull(peer);
  }
  const PeerLines::Place place = lines.Take(peer.address, caller);
  ++host.counters.passed_on;
  PeerExchange exchange(host.io, host.options.limits.peers, peer);
  const std::string hop = SealedHop(host, request, peer);
  auto answer = co_await exchange.Ask(request, hop);
  if (!answer) ++host.counters.peers_silent;
  co_return answer;
}

}  // namespace

std::string SealedHop(const ConnectionHost& host,
                      const HttpRequest& request,
                      const PeerAddress& peer) {
  HttpRequest sent = request;
  if (sent.method == HttpMethod::kHead) sent.method = HttpMethod::kGet;  // as PeerExchange sends it
  return host.seal->Seal(
      {std::string(request.remote_address), request.https}, peer.name, sent, SystemClock().Wall());
}

core::Error PeerFull(const PeerAddress& peer) {
  return {core::ErrorCode::kBusy,
          "Too many requests wait for server '" + peer.name +
              "', which has what this is about; try again in a few seconds.",
          "",
          "peer_busy"};
}

asio::awaitable<HttpResponse> PassOn(ConnectionHost& host,
                                     const HttpRequest& request,
                                     const AskPeers& ask,
                                     const std::string& caller) {
  std::vector<core::Result<HttpResponse>> answers;
  for (const PeerAddress& peer : ask.peers) {
    if (LineOf(host, request).RoomFor(peer.address, caller) == PeerLines::Room::kCallerFull) {
      co_return CallerFullProblem();
    }
    auto answer = co_await AskPeer(host, request, peer, caller);
    answers.push_back(std::move(answer));
  }
  if (ask.join) {
    const HandlerPool::Turn turn{caller};
    if (auto full = PoolRefusal(host, host.pool, turn)) co_return std::move(*full);
    co_return co_await host.pool.Run(
        host.io, turn, [&ask, &answers] { return ask.join(std::move(answers)); });
  }
  if (!answers.front()) co_return PeerProblem(answers.front().error());
  co_return std::move(answers.front()).value();
}

}  // namespace faultlab::server
