#pragma once

#include <cstdint>
#include <string>

namespace faultlab::hardware {

/// What a message must say, so that agent and server understand each other. 2: epochs are the
/// server's. 3: messages are sealed. 4: rigs describe their bench.
/// 5: samples carry their delta.
inline constexpr std::int32_t kProtocol = 7;

/// The channels of the bus.
inline const std::string kAnnounceChannel = "FAULTLAB.ANNOUNCE";
inline std::string BenchChannel(const std::string& rig) {
  return "FAULTLAB." + rig + ".BENCH";
}
inline std::string CommandChannel(const std::string& rig) {
  return "FAULTLAB." + rig + ".COMMAND";
}
inline std::string ReplyChannel(const std::string& rig) {
  return "FAULTLAB." + rig + ".REPLY";
}
inline std::string StreamChannel(const std::string& rig) {
  return "FAULTLAB." + rig + ".STREAM";
}

/// Samples of a plan in one message: it fits a datagram of an Ethernet frame.
inline constexpr int kPlanChunkSamples = 128;
/// Items of a run in one refill message.
inline constexpr int kRefillItems = 16;
/// Items that one refill request gives; the asker asks again.
inline constexpr int kRefillItemsMax = 512;
/// Longest plan: 600 s at 1 kHz.
inline constexpr std::int64_t kPlanSamplesMax = 600'000;

}  // namespace faultlab::hardware
