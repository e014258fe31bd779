#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hardware/lcm/message_bus.h"
#include "hardware/lcm/sealed_message.h"
#include "tests/fuzz/fuzz_input.h"

namespace faultlab::fuzz {

inline const std::string kRig = "r";

inline hardware::RigKey Key() {
  hardware::RigKey key;
  key.fill(0x5a);
  return key;
}

class DeafBus final : public hardware::MessageBus {
 public:
  void Publish(const std::string&, Bytes) override {}
  void Subscribe(const std::string&, Handler) override {}
  void Handle(std::chrono::milliseconds) override {}
};

/// The body of a message, sealed with the key. If it is a message of the type, it gets the rig's
/// name, so that it passes the first checks; otherwise it is unchanged.
template <typename Message>
struct SealedInput {
  explicit SealedInput(std::string_view body) {
    const auto hash = static_cast<std::uint64_t>(Message::getHash());
    for (int shift = 56; shift >= 0; shift -= 8) {
      raw.push_back(static_cast<std::uint8_t>(hash >> shift));
    }
    raw.insert(raw.end(), body.begin(), body.end());
    message = hardware::FromBytes<Message>(raw);
    if (message) message->rig = kRig;
  }
  std::vector<std::uint8_t> Bytes(const std::string& channel) const {
    return hardware::SealBytes(message ? hardware::ToBytes(*message) : raw, channel, kRig, Key());
  }
  std::vector<std::uint8_t> raw;
  std::optional<Message> message;
};

}  // namespace faultlab::fuzz
