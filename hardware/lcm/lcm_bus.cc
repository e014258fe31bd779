#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <list>
#include <memory>
#include <thread>
#include <utility>

#include "hardware/lcm/message_bus.h"

namespace faultlab::hardware {
namespace {

constexpr int kQueueMessages = 2048;
/// Handlers per turn: others on this thread get theirs.
constexpr int kTurn = 256;
/// A udpm bus tries itself when it is opened and takes one lost datagram, as a busy machine loses
/// them, for a missing route.
constexpr int kOpenTries = 5;
constexpr std::chrono::milliseconds kOpenPause(100);

class LcmBus final : public MessageBus {
 public:
  explicit LcmBus(std::unique_ptr<lcm::LCM> lcm) : lcm_(std::move(lcm)) {}

  void Publish(const std::string& channel, Bytes bytes) override {
    lcm_->publish(channel, bytes.data(), static_cast<unsigned>(bytes.size()));
  }

  void Subscribe(const std::string& channels, Handler handler) override {
    subscribers_.push_back({.bus = this, .handler = std::move(handler)});
    lcm::Subscription* subscription =
        lcm_->subscribeFunction<Subscriber*>(channels, &LcmBus::OnMessage, &subscribers_.back());
    subscription->setQueueCapacity(kQueueMessages);
  }

  void Handle(std::chrono::milliseconds patience) override {
    if (lcm_->handleTimeout(static_cast<int>(patience.count())) > 0) {
      for (int i = 1; i < kTurn && !thrown_ && lcm_->handleTimeout(0) > 0; ++i) {
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

  const std::unique_ptr<lcm::LCM> lcm_;
  std::list<Subscriber> subscribers_;
  std::exception_ptr thrown_;
};

}  // namespace

core::Result<std::unique_ptr<MessageBus>> OpenLcmBus(const std::string& url) {
  std::string full = url;
  if (url.rfind("udpm://", 0) == 0 && url.find("recv_buf_size") == std::string::npos) {
    full += (url.find('?') == std::string::npos ? "?" : "&") + std::string("recv_buf_size=4000000");
  }
  for (int attempt = 1; attempt <= kOpenTries; ++attempt) {
    auto lcm = std::make_unique<lcm::LCM>(full);
    if (lcm->good()) return std::unique_ptr<MessageBus>(std::make_unique<LcmBus>(std::move(lcm)));
    if (attempt < kOpenTries) std::this_thread::sleep_for(attempt * kOpenPause);
  }
  return core::Error{
      .code = core::ErrorCode::kUnavailable,
      .message = "the LCM bus " + url +
                 " does not open; udpm needs a multicast route (on one machine: ip link set lo "
                 "multicast on; ip route add 239.255.76.67/32 dev lo)",
      .field = "lcm"};
}

}  // namespace faultlab::hardware
