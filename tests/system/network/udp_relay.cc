#include "tests/system/network/udp_relay.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <deque>
#include <optional>
#include <span>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/signals/random.h"

namespace faultlab::hardware {
namespace {

using Datagram = std::vector<std::uint8_t>;
using SteadyTime = std::chrono::steady_clock::time_point;

/// A socket on a multicast group that receives from everybody except itself.
class GroupSocket {
 public:
  explicit GroupSocket(int port)
      : in_(socket(AF_INET, SOCK_DGRAM, 0)), out_(socket(AF_INET, SOCK_DGRAM, 0)) {
    group_.sin_family = AF_INET;
    group_.sin_port = htons(static_cast<std::uint16_t>(port));
    inet_pton(AF_INET, "239.255.76.67", &group_.sin_addr);
    const int on = 1;
    setsockopt(in_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    setsockopt(in_, SOL_SOCKET, SO_REUSEPORT, &on, sizeof on);
    const int buffer = 4'000'000;
    setsockopt(in_, SOL_SOCKET, SO_RCVBUFFORCE, &buffer, sizeof buffer);  // root has the right
    sockaddr_in any = group_;
    any.sin_addr.s_addr = htonl(INADDR_ANY);
    ip_mreq membership{};
    membership.imr_multiaddr = group_.sin_addr;
    if (bind(in_, reinterpret_cast<sockaddr*>(&any), sizeof any) != 0 ||
        setsockopt(in_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) != 0) {
      throw std::runtime_error("no multicast here");
    }
    sockaddr_in self{};
    self.sin_family = AF_INET;
    bind(out_, reinterpret_cast<sockaddr*>(&self), sizeof self);
    socklen_t size = sizeof self;
    getsockname(out_, reinterpret_cast<sockaddr*>(&self), &size);
    own_port_ = self.sin_port;
  }
  ~GroupSocket() {
    close(in_);
    close(out_);
  }

  int fd() const { return in_; }

  std::optional<Datagram> Receive() {
    std::array<std::uint8_t, 65536> buffer;
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t got = recvfrom(
        in_, buffer.data(), buffer.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &size);
    if (got < 0) return std::nullopt;
    if (from.sin_port == own_port_) return Datagram();  // our own datagram
    return Datagram(buffer.begin(), buffer.begin() + got);
  }

  void Send(std::span<const std::uint8_t> datagram) {
    sendto(out_,
           datagram.data(),
           datagram.size(),
           0,
           reinterpret_cast<const sockaddr*>(&group_),
           sizeof group_);
  }

 private:
  const int in_;
  const int out_;
  sockaddr_in group_{};
  in_port_t own_port_ = 0;
};

}  // namespace

struct UdpRelay::State {
  State(int port_a, int port_b, RelayWeather w, std::uint64_t seed)
      : a(port_a), b(port_b), weather(w), random(seed) {
    thread = std::thread([this] { Loop(); });
  }
  ~State() {
    stop = true;
    thread.join();
  }

  struct Later {
    SteadyTime at;
    GroupSocket* to;
    Datagram datagram;
  };

  void Loop() {
    while (!stop) {
      std::array<pollfd, 2> waits = {pollfd{.fd = a.fd(), .events = POLLIN, .revents = 0},
                                     pollfd{.fd = b.fd(), .events = POLLIN, .revents = 0}};
      poll(waits.data(), waits.size(), 2);
      Carry(a, b);
      Carry(b, a);
      const SteadyTime now = std::chrono::steady_clock::now();
      while (!later.empty() && later.front().at <= now) {
        later.front().to->Send(later.front().datagram);
        later.pop_front();
      }
    }
  }

  void Carry(GroupSocket& from, GroupSocket& to) {
    while (const std::optional<Datagram> datagram = from.Receive()) {
      if (datagram->empty()) continue;
      if (cut || random.Uniform() < weather.loss) {
        ++lost;
        continue;
      }
      const SteadyTime at =
          std::chrono::steady_clock::now() + std::chrono::milliseconds(weather.delay_ms);
      ++passed;
      if (random.Uniform() < weather.reorder) {
        held.push_back({at, &to, *datagram});
        continue;
      }
      later.push_back({at, &to, *datagram});
      if (random.Uniform() < weather.duplicate) later.push_back({at, &to, *datagram});
      for (Later& late : held) {
        late.at = at;
        later.push_back(std::move(late));
      }
      held.clear();
    }
  }

  GroupSocket a;
  GroupSocket b;
  const RelayWeather weather;
  core::Random random;
  std::deque<Later> later;
  std::deque<Later> held;
  std::atomic<bool> cut{false};
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> passed{0};
  std::atomic<std::uint64_t> lost{0};
  std::thread thread;
};

UdpRelay::UdpRelay(int port_a, int port_b, RelayWeather weather, std::uint64_t seed)
    : state_(std::make_unique<State>(port_a, port_b, weather, seed)) {}
UdpRelay::~UdpRelay() = default;
void UdpRelay::SetCut(bool cut) {
  state_->cut = cut;
}
std::uint64_t UdpRelay::passed() const {
  return state_->passed;
}
std::uint64_t UdpRelay::lost() const {
  return state_->lost;
}

struct UdpProbe::State {
  explicit State(int port) : group(port) {}
  GroupSocket group;
};

UdpProbe::UdpProbe(int port) : state_(std::make_unique<State>(port)) {}
UdpProbe::~UdpProbe() = default;
void UdpProbe::Send(std::span<const std::uint8_t> datagram) {
  state_->group.Send(datagram);
}
std::optional<Datagram> UdpProbe::Receive() {
  std::optional<Datagram> datagram = state_->group.Receive();
  while (datagram && datagram->empty()) datagram = state_->group.Receive();
  return datagram;
}

struct UdpImpostor::State {
  /// Limits how many forged datagrams follow each received one, so that the test does not overload
  /// a busy machine.
  static constexpr int kForged = 8;

  State(int port, std::uint64_t seed) : group(port), random(seed) {
    thread = std::thread([this] { Loop(); });
  }
  ~State() {
    stop = true;
    thread.join();
  }

  void Loop() {
    std::deque<Datagram> heard;
    while (!stop) {
      pollfd wait{.fd = group.fd(), .events = POLLIN, .revents = 0};
      poll(&wait, 1, 1);
      int owed = 0;
      while (const std::optional<Datagram> datagram = group.Receive()) {
        if (datagram->empty()) continue;
        heard.push_back(*datagram);
        owed += kForged;
        if (heard.size() > 1000) heard.pop_front();
      }
      for (; owed > 0; --owed) {
        Datagram again = heard[random.Below(heard.size())];
        if (random.Uniform() < 0.5) {
          // After LCM's own header and the channel's name, so that it arrives as a message.
          const std::size_t from = std::min<std::size_t>(again.size() - 1, 40);
          again[from + random.Below(again.size() - from)] ^= 0x10;
        }
        group.Send(again);
        ++sent;
      }
    }
  }

  GroupSocket group;
  core::Random random;
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> sent{0};
  std::thread thread;
};

UdpImpostor::UdpImpostor(int port, std::uint64_t seed)
    : state_(std::make_unique<State>(port, seed)) {}
UdpImpostor::~UdpImpostor() = default;
std::uint64_t UdpImpostor::sent() const {
  return state_->sent;
}

}  // namespace faultlab::hardware
