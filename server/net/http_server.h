#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/types/result.h"
#include "server/net/hop.h"
#include "server/net/http.h"
#include "server/net/peer_limits.h"
#include "server/net/pool_limits.h"
#include "server/net/router.h"
#include "server/net/trusted_proxies.h"

namespace faultlab::server {

struct HttpLimits {
  std::size_t header_bytes_max = 16 << 10;
  std::size_t connections_max = 4096;  ///< when there are more, one that waits is closed
  std::size_t connections_per_address_max = 1024;  ///< of clients that come through no proxy
  /// Bodies of one caller that have not come along with their header; more are 429.
  std::size_t slow_bodies_per_caller_max = 64;
  PoolLimits pool;  ///< of handlers that wait for disk or database
  PoolLimits heavy{.threads = 2, .waiting_max = 256, .waiting_per_caller_max = 24, .nice = 10};
  PoolLimits outside{
      .threads = 8, .waiting_max = 256, .waiting_per_caller_max = 128, .threads_per_lane = 3};
  PoolLimits password{.threads = 2, .waiting_max = 128, .waiting_per_caller_max = 64, .nice = 5};
  std::size_t waiting_bytes_max = 256 << 20;  ///< unread bodies and unsent answers; more are 503
  std::chrono::milliseconds header_deadline{
      10'000};  ///< first byte of a request to its last header
  std::chrono::milliseconds body_deadline{120'000};
  std::chrono::milliseconds write_deadline{30'000};  ///< of each 512 kB of an answer: 17 kB/s
  std::chrono::milliseconds idle_deadline{75'000};   ///< kept-alive connection between requests
  std::chrono::milliseconds look_every{2'000};       ///< whether who takes an answer still may
  /// Of an answer, in the kernel: out of reach when the right to it ends. The kernel takes twice.
  int send_buffer_bytes = 256 << 10;
  PeerLimits peers;
};

struct HttpServerOptions {
  std::string listen = "127.0.0.1:8080";  ///< "host:port", "[::1]:0"; port 0 = any free one
  HttpLimits limits;
  /// Host names a request may carry besides IP literals of this listener and "localhost" (DNS
  /// rebinding is refused by this). Empty and not on loopback: any.
  std::vector<std::string> allowed_hosts;
  /// Whose X-Forwarded-For and -Proto are believed, besides loopback: "10.0.0.2", "10.1.0.0/16".
  TrustedProxies trusted_proxies;
  /// Told of handlers that threw and of sockets that could not be accepted. Any thread.
  std::function<void(std::string_view)> on_error;
};

/// A socket that has switched to the WebSocket protocol, 101 already sent.
struct UpgradedSocket {
  int fd = -1;          ///< non-blocking; the taker owns it
  std::string pending;  ///< bytes the client sent behind its handshake
};

/// Answer to a request to become a WebSocket: a refusal, who takes the socket, or the server at
/// which it ends: then the bytes go through this one both ways.
using UpgradeDecision =
    std::variant<HttpResponse, std::function<void(UpgradedSocket)>, PeerAddress>;

struct HttpCounters {
  std::uint64_t connections_accepted = 0;
  std::uint64_t connections_refused = 0;
  std::uint64_t connections_open = 0;
  std::uint64_t requests = 0;
  std::uint64_t answers_by_class[6] = {};  ///< [2] = 2xx ..
  std::uint64_t deadlines_missed = 0;
  std::uint64_t pool_refused = 0;   ///< requests
  std::uint64_t pool_waiting = 0;   ///< in all pools
  std::uint64_t bytes_refused = 0;  ///< requests refused because too many bytes waited
  std::uint64_t passed_on = 0;      ///< requests that other servers were asked
  std::uint64_t peers_silent = 0;   ///< of those, how many got no answer
  std::uint64_t tunnels_open = 0;   ///< WebSockets that end at another server
};

/// HTTP/1.1 on one network thread. Deadlines on every read and write, limits that hold before a
/// byte of the body is stored, keep-alive, HEAD, security headers on each answer.
/// Handlers marked kPool run on a small pool; the network thread never waits for them.
class HttpServer {
 public:
  /// `router` must outlive the server. `upgrade` decides on GETs that ask for a WebSocket; it runs
  /// on the network thread and must not block.
  HttpServer(HttpServerOptions options,
             const Router& router,
             std::function<UpgradeDecision(const HttpRequest&)> upgrade);
  ~HttpServer();  ///< Stop()
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// From now on hops of the other servers are believed, and requests passed on to them. Before
  /// Start(); without it a request that carries a hop is refused.
  void SetHopSeal(HopSeal seal);
  /// Takes the address: connections wait from now on. Refuses with a sentence naming it.
  core::Status Bind();
  /// Starts the threads, which answer. Binds first when Bind has not been called.
  core::Status Start();
  /// The real port, after Bind().
  int port() const;
  std::string address() const;  ///< "127.0.0.1:40123", "[::1]:40123"
  /// True when only this machine can reach the listener.
  bool on_loopback() const;
  /// Stops accepting, lets running handlers finish (their answers are sent within a second), joins.
  void Stop();

  HttpCounters counters() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace faultlab::server
