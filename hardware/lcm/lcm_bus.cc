#include <exception>
#include <lcm/lcm-cpp.hpp>
#include <list>
#include <memory>
#include <utility>

#include "hardware/lcm/bus_url.h"
#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/udpm_bus.h"

namespace faultlab::hardware {
namespace {

constexpr int kQueueMessages = 2048;
/// Handlers per turn: others on this thread get theirs.
constexpr int kMessagesATurn = 256;

/// A bus without a network: memq://, file://.
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
      for (int i = 1; i < kMessagesATurn && !thrown_ && lcm_->handleTimeout(0) > 0; ++i) {
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
  if (const core::Status status = CheckBusUrl(url); !status) return status.error();
  if (const auto udpm = ParseUdpmUrl(url)) {
    auto bus = OpenUdpmBus(udpm.value());
    if (!bus) return BusDoesNotOpen(url, bus.error().message);
    return bus;
  }
  auto lcm = std::make_unique<lcm::LCM>(url);
  if (!lcm->good()) return BusDoesNotOpen(url, "");
  return std::unique_ptr<MessageBus>(std::make_unique<LcmBus>(std::move(lcm)));
}

}  // namespace faultlab::hardware
