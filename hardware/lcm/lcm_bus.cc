#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <list>
#include <utility>

#include "hardware/lcm/message_bus.h"

namespace faultlab::hardware {
namespace {

constexpr int kQueueMessages = 2048;
/// Handlers per turn: others on this thread get theirs.
constexpr int kTurn = 256;

class LcmBus final : public MessageBus {
 public:
  explicit LcmBus(const std::string& url) : lcm_(url) {}

  bool good() { return lcm_.good(); }

  void Publish(const std::string& channel, Bytes bytes) override {
    lcm_.publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
  }

  void Subscribe(const std::string& channels, Handler handler) override {
    subscribers_.push_back({.bus = this, .handler = std::move(handler)});
    lcm::Subscription* subscription =
        lcm_.subscribeFunction<Subscriber*>(channels, &LcmBus::OnMessage, &subscribers_.back());
    subscription->setQueueCapacity(kQueueMessages);
  }

  void Handle(std::chrono::milliseconds patience) override {
    if (lcm_.handleTimeout(static_cast<int>(patience.count())) > 0) {
      for (int i = 1; i < kTurn && !thrown_ && lcm_.handleTimeout(0) > 0; ++i) {
      }
    }
    if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
  }

 private:
  struct Subscriber {
    LcmBus* bus;
    Handler handler;
  };

  /// An exception must not cross liblcm's C frames.
  static void OnMessage(const lcm::ReceiveBuffer* buffer,
                        const std::string& channel,
                        Subscriber* subscriber) {
    try {
      subscriber->handler(channel,
                          Bytes(static_cast<const std::uint8_t*>(buffer->data), buffer->data_size));
    } catch (...) {
      if (!subscriber->bus->thrown_) subscriber->bus->thrown_ = std::current_exception();
    }
  }

  lcm::LCM lcm_;
  std::list<Subscriber> subscribers_;
  std::exception_ptr thrown_;
};

}  // namespace

core::Result<std::unique_ptr<MessageBus>> OpenLcmBus(const std::string& url) {
  std::string full = url;
  if (url.rfind("udpm://", 0) == 0 && url.find("recv_buf_size") == std::string::npos) {
    full += (url.find('?') == std::string::npos ? "?" : "&") + std::string("recv_buf_size=4000000");
  }
  auto bus = std::make_unique<LcmBus>(full);
  if (!bus->good()) {
    return core::Error{
        .code = core::ErrorCode::kUnavailable,
        .message = "the LCM bus " + url +
                   " does not open; udpm needs a multicast route (on one machine: ip link set lo "
                   "multicast on; ip route add 239.255.76.67/32 dev lo)",
        .field = "lcm"};
  }
  return std::unique_ptr<MessageBus>(std::move(bus));
}

}  // namespace faultlab::hardware
