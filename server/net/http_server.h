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
#include "server/net/forwarding_seal.h"
#include "server/net/http.h"
#include "server/net/peer_limits.h"
#include "server/net/pool_limits.h"
#include "server/net/router.h"
#include "server/net/trusted_proxies.h"

namespace faultlab::server {

struct HttpLimits {
  std::size_t header_bytes_max = 16 << 10;
  std::size_t connections_max = 4096;  ///< above this number a waiting connection is closed
  /// Requests that wait for a change (HttpResponse::patience); others are answered at once.
  std::size_t waits_max = 1024;
  std::size_t waits_per_caller_max = 64;
  std::size_t connections_per_address_max = 1024;  ///< of clients that do not come through a proxy
  /// Bodies of one caller that did not arrive with their header; more are refused with 429.
  std::size_t slow_bodies_per_caller_max = 64;
  PoolLimits pool;  ///< of handlers that wait for disk or database
  PoolLimits heavy{.threads = 2, .waiting_max = 256, .waiting_per_caller_max = 24, .nice = 10};
  PoolLimits outside{
      .threads = 8, .waiting_max = 256, .waiting_per_caller_max = 128, .threads_per_lane = 3};
  PoolLimits password{.threads = 2, .waiting_max = 128, .waiting_per_caller_max = 64, .nice = 5};
  std::size_t waiting_bytes_max = 256 << 20;  ///< unread bodies and unsent answers; above: 503
  std::chrono::milliseconds header_deadline{
      10'000};  ///< from the first byte of a request to its last header
  std::chrono::milliseconds body_deadline{120'000};
  std::chrono::milliseconds write_deadline{30'000};  ///< of each 512 kB of an answer: 17 kB/s
  std::chrono::milliseconds idle_deadline{75'000};   ///< kept-alive connection between requests
  std::chrono::milliseconds look_every{2'000};       ///< interval of the calls of `still_may`
  /// Of an answer, in the kernel, which a later loss of permission cannot stop. The kernel doubles
  /// it.
  int send_buffer_bytes = 256 << 10;
  PeerLimits peers;
};

struct HttpServerOptions {
  std::string listen = "127.0.0.1:8080";  ///< "host:port", "[::1]:0"; port 0 = any free one
  HttpLimits limits;
  /// Host names that a request may carry besides IP literals of this listener and "localhost" (this
  /// refuses DNS rebinding). Empty and not on loopback: any name.
  std::vector<std::string> allowed_hosts;
  /// Proxies whose X-Forwarded-For and -Proto are trusted, besides loopback: "10.0.0.2",
  /// "10.1.0.0/16".
  TrustedProxies trusted_proxies;
  /// Called when a handler has thrown or a socket could not be accepted. Any thread.
  std::function<void(std::string_view)> on_error;
};

/// A socket that has switched to the WebSocket protocol, 101 already sent.
struct UpgradedSocket {
  int fd = -1;          ///< non-blocking; the receiver owns it
  std::string pending;  ///< bytes that the client sent after its handshake
};

/// Answer to a request to become a WebSocket: a refusal, a receiver of the socket, or the server at
/// which it ends; in the last case this server copies the bytes in both directions.
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
  std::uint64_t bytes_refused = 0;  ///< refused because too many bytes waited
  std::uint64_t bytes_waiting = 0;  ///< bodies not completely read, answers not completely sent
  std::uint64_t passed_on = 0;      ///< requests passed on to other servers
  std::uint64_t peers_silent = 0;   ///< those of them that got no answer
  std::uint64_t tunnels_open = 0;   ///< WebSockets that end at another server
  std::uint64_t waits_open = 0;     ///< requests that wait for a change
};

/// HTTP/1.1 on one network thread. Deadlines on every read and write, limits that apply before a
/// byte of the body is stored, keep-alive, HEAD, security headers on each answer. Handlers marked
/// kPool run on a small pool; the network thread never waits for them.
class HttpServer {
 public:
  /// `router` must outlive the server. `upgrade` decides about GETs that ask for a WebSocket; it
  /// runs on the network thread and must not block.
  HttpServer(HttpServerOptions options,
             const Router& router,
             std::function<UpgradeDecision(const HttpRequest&)> upgrade);
  ~HttpServer();  ///< Stop()
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  /// Sets the seal: hops of the other servers are then trusted, and requests are passed on to them.
  /// To be called before Start(); without it a request with a hop is refused.
  void SetHopSeal(ForwardingSeal seal);
  /// Binds the address; connections may wait from then on. A refusal names the address.
  core::Status Bind();
  /// Starts the threads, which answer requests. Binds first if Bind was not called.
  core::Status Start();
  /// The actual port, after Bind().
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
