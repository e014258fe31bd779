#pragma once

#include <chrono>
#include <cstddef>

namespace faultlab::server {

/// How long and how much one server waits for another one.
struct PeerLimits {
  std::chrono::milliseconds connect_deadline{1'000};
  std::chrono::milliseconds answer_deadline{3'000};  ///< of GET; then the peer counts as silent
  std::chrono::milliseconds change_deadline{8'000};  ///< of the rest: a rig may have to be started
  std::size_t answer_bytes_max = 4 << 20;
  std::size_t waiting_max = 96;             ///< that read, and as many that change; more: 503
  std::size_t waiting_per_caller_max = 16;  ///< of them, of one caller; more are 429
  /// WebSockets that end at a peer; more are 503. Beside the requests `waiting_max` handshakes wait
  /// for one peer: a stranger may begin one. One address has at most half of each; then it is 429.
  std::size_t tunnels_max = 4096;
  /// A tunnel ends when its peer says nothing for so long; viewers are pinged every 15 s.
  std::chrono::milliseconds tunnel_silence{45'000};
};

}  // namespace faultlab::server
