#pragma once

#include <chrono>
#include <cstddef>

namespace faultlab::server {

/// Limits for one server that waits for another one.
struct PeerLimits {
  std::chrono::milliseconds connect_deadline{1'000};
  std::chrono::milliseconds answer_deadline{3'000};  ///< for GET; then the peer counts as silent
  std::chrono::milliseconds change_deadline{8'000};  ///< other methods: a rig may have to start
  std::size_t answer_bytes_max = 4 << 20;
  /// Requests that wait for one peer: this many that read, and as many that change; more get 503.
  std::size_t waiting_max = 96;
  std::size_t waiting_per_caller_max = 16;  ///< of each kind, of one caller; more get 429
  /// WebSockets that end at a peer; more get 503. In addition, `waiting_max` handshakes may wait
  /// for one peer, because anybody may begin one. One address has at most half of each, above which
  /// it gets 429.
  std::size_t tunnels_max = 4096;
  /// A tunnel ends when its peer is silent for this long; viewers are pinged every 15 s.
  std::chrono::milliseconds tunnel_silence{45'000};
};

}  // namespace faultlab::server
