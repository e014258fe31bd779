#include "hardware/lcm/udpm_bus.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>
#include <algorithm>

#include <array>
#include <cerrno>
#include <mutex>
#include <optional>
#include <regex>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "hardware/lcm/lcm_packet.h"
#include "hardware/lcm/message_assembly.h"

namespace faultlab::hardware {
namespace {

/// Datagrams per turn: others on this thread get theirs, also in a flood.
constexpr int kDatagramsATurn = 256;
constexpr std::size_t kDatagramBytesMax = 1u << 16;

class UdpSocket {
 public:
  UdpSocket() = default;
  ~UdpSocket() {
    if (fd_ >= 0) close(fd_);
  }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  /// This and Set: false with errno.
  bool Create() {
    fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    return fd_ >= 0;
  }
  int fd() const { return fd_; }
  template <typename Value>
  bool Set(int level, int option, const Value& value) {
    return setsockopt(fd_, level, option, &value, sizeof value) == 0;
  }

 private:
  int fd_ = -1;
};

class UdpmBus final : public MessageBus {
 public:
  explicit UdpmBus(const UdpmUrl& url) : assembly_([this](auto name) { return HasHandler(name); }) {
    group_.sin_family = AF_INET;
    group_.sin_port = htons(url.port);
    group_.sin_addr = url.group;
  }

  /// False with errno.
  bool Open(const UdpmUrl& url) {
    if (!in_.Create() || !out_.Create()) return false;
    // A socket and port of its own: LCM knows a sender by address and port.
    if (!out_.Set(IPPROTO_IP, IP_MULTICAST_TTL, url.ttl)) return false;
    // Above net.core.rmem_max with CAP_NET_ADMIN, else up to it.
    if (!in_.Set(SOL_SOCKET, SO_RCVBUFFORCE, url.receive_bytes) &&
        !in_.Set(SOL_SOCKET, SO_RCVBUF, url.receive_bytes)) {
      return false;
    }
    // Every process of this machine that binds so gets each datagram. Bound to the group, the
    // socket gets none that was sent to this machine alone.
    const ip_mreq membership{.imr_multiaddr = url.group, .imr_interface = {INADDR_ANY}};
    return in_.Set(SOL_SOCKET, SO_REUSEADDR, 1) &&
           bind(in_.fd(), reinterpret_cast<const sockaddr*>(&group_), sizeof group_) == 0 &&
           in_.Set(IPPROTO_IP, IP_ADD_MEMBERSHIP, membership);
  }

  void Publish(const std::string& channel, Bytes bytes) override {
    const std::lock_guard lock(out_mutex_);  // the fragments of a message stay together
    WriteLcmPackets(sequence_++, channel, bytes, [this](Bytes head, Bytes payload) {
      std::array<iovec, 2> parts = {Part(head), Part(payload)};
      msghdr datagram{};
      datagram.msg_name = &group_;
      datagram.msg_namelen = sizeof group_;
      datagram.msg_iov = parts.data();
      datagram.msg_iovlen = parts.size();
      (void)sendmsg(out_.fd(), &datagram, 0);
    });
  }

  void Subscribe(const std::string& channels, Handler handler) override {
    subscribers_.push_back({.channels = std::regex(channels), .handler = std::move(handler)});
  }

  void Handle(std::chrono::milliseconds patience) override {
    pollfd wait{.fd = in_.fd(), .events = POLLIN, .revents = 0};
    if (poll(&wait, 1, static_cast<int>(patience.count())) <= 0) return;
    for (int i = 0; i < kDatagramsATurn; ++i) {
      sockaddr_in from{};
      socklen_t from_bytes = sizeof from;
      const ssize_t got = recvfrom(in_.fd(),
                                   datagram_.data(),
                                   datagram_.size(),
                                   MSG_DONTWAIT,
                                   reinterpret_cast<sockaddr*>(&from),
                                   &from_bytes);
      if (got < 0) return;
      OnDatagram({.address = from.sin_addr.s_addr, .port = from.sin_port},
                 Bytes(datagram_).first(static_cast<std::size_t>(got)));
    }
  }

 private:
  struct Subscriber {
    std::regex channels;
    Handler handler;
    bool Takes(std::string_view channel) const {
      return std::regex_match(channel.begin(), channel.end(), channels);
    }
  };

  static iovec Part(Bytes bytes) {
    return {.iov_base = const_cast<std::uint8_t*>(bytes.data()), .iov_len = bytes.size()};
  }

  void OnDatagram(const LcmSender& sender, Bytes datagram) {
    const std::optional<LcmPacket> packet = ReadLcmPacket(datagram);
    if (!packet) return;
    if (packet->count == 1) {
      Deliver(std::string(packet->channel), packet->payload);
    } else if (const auto message = assembly_.Add(sender, *packet)) {
      Deliver(message->channel, message->bytes);
    }
  }

  void Deliver(const std::string& channel, Bytes bytes) {
    for (const Subscriber& subscriber : subscribers_) {
      if (subscriber.Takes(channel)) subscriber.handler(channel, bytes);
    }
  }

  bool HasHandler(std::string_view channel) const {
    return std::ranges::any_of(
        subscribers_, [&](const Subscriber& subscriber) { return subscriber.Takes(channel); });
  }

  sockaddr_in group_{};
  UdpSocket in_;
  UdpSocket out_;
  std::mutex out_mutex_;
  std::uint32_t sequence_ = 0;
  std::vector<Subscriber> subscribers_;
  MessageAssembly assembly_;
  std::vector<std::uint8_t> datagram_ = std::vector<std::uint8_t>(kDatagramBytesMax);
};

}  // namespace

core::Result<std::unique_ptr<MessageBus>> OpenUdpmBus(const UdpmUrl& url) {
  auto bus = std::make_unique<UdpmBus>(url);
  if (!bus->Open(url)) {
    return core::Error{.code = core::ErrorCode::kUnavailable,
                       .message = std::generic_category().message(errno),
                       .field = "lcm"};
  }
  return std::unique_ptr<MessageBus>(std::move(bus));
}

}  // namespace faultlab::hardware
