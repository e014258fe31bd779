#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace faultlab::hardware {

/// A bad network connection: carries UDP datagrams between two multicast groups of this machine,
/// and loses, duplicates and delays some of them. For kernels without tc netem.
struct RelayWeather {
  double loss = 0.0;
  double duplicate = 0.0;
  double reorder = 0.0;  ///< probability that a datagram waits until the next one has overtaken it
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
  /// The next datagram of another sender; nothing if there is none.
  std::optional<std::vector<std::uint8_t>> Receive();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// While it exists, it sends 8 datagrams for every one that it receives on the group: repetitions
/// of earlier ones, half of them with some bits flipped.
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
