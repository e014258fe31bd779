#pragma once

#include <array>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>

#include "server/net/byte_budget.h"
#include "server/net/client_counts.h"
#include "server/net/handler_pool.h"
#include "server/net/http_server.h"
#include "server/net/peer_lines.h"

namespace faultlab::server {

class Connection;

/// The data that the connections of one server share. Only the atomics may be read by other threads
/// than the network thread.
struct ConnectionHost {
  struct Counters {
    std::atomic<std::uint64_t> accepted{0}, refused{0}, open{0}, requests{0}, deadlines{0},
        pool_refused{0}, bytes_refused{0}, passed_on{0}, peers_silent{0}, tunnels{0}, waits{0};
    std::array<std::atomic<std::uint64_t>, 6> answers{};
  };

  HttpServerOptions options;
  const Router& router;
  std::function<UpgradeDecision(const HttpRequest&)> upgrade;
  bool on_loopback = false;
  std::optional<ForwardingSeal> seal{};  ///< of the lab's servers; set before the threads start
  Counters counters{};
  ByteBudget waiting_bytes{options.limits.waiting_bytes_max};
  std::unordered_set<Connection*> connections{};
  ClientCounts of_address{};    ///< connections, by AddressKey of the peer
  ClientCounts slow_clients{};  ///< connections that wait for their client, by client
  ClientCounts slow_bodies{};   ///< those of them that read a body
  ClientCounts waits{};         ///< requests that wait for a change, by caller
  /// Requests that wait for each of the other servers, by caller: those that read, and those that
  /// change, whose places readers cannot take. WebSocket handshakes, by the client's address.
  PeerLines reads_at_peer{options.limits.peers.waiting_max,
                          options.limits.peers.waiting_per_caller_max};
  PeerLines changes_at_peer{options.limits.peers.waiting_max,
                            options.limits.peers.waiting_per_caller_max};
  PeerLines handshakes_with_peer{options.limits.peers.waiting_max,
                                 (options.limits.peers.waiting_max + 1) / 2};
  ClientCounts tunnels_of_client{};             ///< by the client's address
  std::chrono::steady_clock::time_point now{};  ///< coarse: updated twice a second
  std::string date{};                           ///< of `now`, in the format of HTTP
  // Connections live in coroutines that io owns. Members above io outlive it, because the
  // coroutines use them.
  HandlerPool pool{options.limits.pool};
  HandlerPool heavy{options.limits.heavy};
  HandlerPool password{options.limits.password};
  HandlerPool outside{options.limits.outside};
  boost::asio::io_context io{1};

  /// Takes bytes for a body or an answer of `asker`. When the budget is full, connections that wait
  /// for their clients are closed until there is room: those without an account for one with an
  /// account, otherwise those of a caller who holds more. Nothing when no connection may be closed.
  std::optional<ByteBudget::Reservation> TakeBytes(std::size_t bytes, const Connection& asker);

  std::array<HandlerPool*, 4> Pools() { return {&pool, &heavy, &password, &outside}; }
  HandlerPool& PoolOf(RunsOn runs_on) {
    if (runs_on == RunsOn::kHeavy) return heavy;
    if (runs_on == RunsOn::kOutside) return outside;
    return runs_on == RunsOn::kPassword ? password : pool;
  }
  void Report(std::string_view text) const {
    if (options.on_error) options.on_error(text);
  }
};

}  // namespace faultlab::server
