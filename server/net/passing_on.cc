#include "server/net/passing_on.h"

#include <utility>
#include <vector>

#include "server/address_key.h"
#include "server/clock.h"
#include "server/net/admission_desk.h"
#include "server/net/peer.h"
#include "server/net/refusals.h"

namespace faultlab::server {
namespace {

namespace asio = boost::asio;

asio::awaitable<core::Result<HttpResponse>> AskPeer(ConnectionHost& host,
                                                    const HttpRequest& request,
                                                    const PeerAddress& peer) {
  const core::Error busy{core::ErrorCode::kBusy,
                         "Too many requests wait for server '" + peer.name +
                             "', which has what this is about; try again in a few seconds.",
                         ""};
  if (!host.seal) co_return busy;
  int& waiting = host.waiting_for_peer[peer.address];
  if (waiting >= host.options.limits.peers.waiting_max) co_return busy;
  ++waiting;
  ++host.counters.passed_on;
  PeerExchange exchange(host.io, host.options.limits.peers, peer);
  const std::string hop = SealedHop(host, request, peer);
  auto answer = co_await exchange.Ask(request, hop);
  if (!answer) ++host.counters.peers_silent;
  const auto entry = host.waiting_for_peer.find(peer.address);
  if (--entry->second == 0) host.waiting_for_peer.erase(entry);
  co_return answer;
}

}  // namespace

std::string SealedHop(const ConnectionHost& host,
                      const HttpRequest& request,
                      const PeerAddress& peer) {
  HttpRequest sent = request;
  if (sent.method == HttpMethod::kHead) sent.method = HttpMethod::kGet;  // as PeerExchange asks
  return host.seal->Seal(
      {std::string(request.remote_address), request.https}, peer.name, sent, SystemClock().Wall());
}

asio::awaitable<HttpResponse> PassOn(ConnectionHost& host,
                                     const HttpRequest& request,
                                     const AskPeers& ask) {
  std::vector<core::Result<HttpResponse>> answers;
  for (const PeerAddress& peer : ask.peers) {
    auto answer = co_await AskPeer(host, request, peer);
    answers.push_back(std::move(answer));
  }
  if (ask.join) {
    const HandlerPool::Turn turn{AddressKey(request.remote_address)};
    if (auto full = PoolRefusal(host, host.pool, turn)) co_return std::move(*full);
    co_return co_await host.pool.Run(
        host.io, turn, [&ask, &answers] { return ask.join(std::move(answers)); });
  }
  if (!answers.front()) co_return PeerProblem(answers.front().error());
  co_return std::move(answers.front()).value();
}

}  // namespace faultlab::server
