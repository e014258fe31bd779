#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace faultlab::hardware {

/// Bad weather on a real network: carries UDP datagrams between two multicast groups of this
/// machine, losing, doubling and delaying some. For kernels without tc netem.
struct RelayWeather {
  double loss = 0.0;
  double duplicate = 0.0;
  double reorder = 0.0;  ///< waits until the next datagram has overtaken it
  int delay_ms = 0;      ///< of every datagram
};

class UdpRelay {
 public:
  /// Ports of 239.255.76.67.
  UdpRelay(int port_a, int port_b, RelayWeather weather, std::uint64_t seed);
  ~UdpRelay();
  void SetCut(bool cut);
  std::uint64_t passed() const;
  std::uint64_t lost() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Bare datagrams to and from the group, without LCM.
class UdpProbe {
 public:
  explicit UdpProbe(int port);
  ~UdpProbe();
  void Send(std::span<const std::uint8_t> datagram);
  /// The next one that was sent by somebody else; nothing when none is there.
  std::optional<std::vector<std::uint8_t>> Receive();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// While it lives, sends 8 for every datagram that it hears on the group: earlier ones again, half
/// of them with some bits turned.
class UdpImpostor {
 public:
  UdpImpostor(int port, std::uint64_t seed);
  ~UdpImpostor();
  std::uint64_t sent() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace faultlab::hardware
