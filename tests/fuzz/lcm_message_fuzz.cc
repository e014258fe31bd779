// Any bytes from the bus or in a log: an accepted message is complete, the rest is refused without
// a crash.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "hardware/lcm/lcm_log.h"
#include "hardware/lcm/message_codec.h"
#include "hardware/lcm/rig_codec.h"
#include "hardware/lcm/sealed_message.h"
#include "tests/paper_bench.h"

namespace {

using namespace faultlab::hardware;  // NOLINT(google-build-using-namespace)
using Bytes = std::vector<std::uint8_t>;

void Require(bool condition) {
  if (!condition) std::abort();
}

/// The body that follows the hash of its type, as a message of the type.
template <typename Message>
void Check(const Bytes& body) {
  Bytes bytes;
  const auto hash = static_cast<std::uint64_t>(Message::getHash());
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(hash >> shift));
  }
  bytes.insert(bytes.end(), body.begin(), body.end());
  if (const auto message = FromBytes<Message>(bytes)) Require(ToBytes(*message) == bytes);
}

template <typename... Messages>
void CheckOne(std::size_t which, const Bytes& body, MessageList<Messages...>) {
  std::size_t i = 0;
  ((i++ == which % sizeof...(Messages) ? Check<Messages>(body) : void()), ...);
}

}  // namespace

/// The first byte selects the type, the rest is the body; all of it is also read as a log.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream log(std::string(reinterpret_cast<const char*>(data), size));
  const auto record = ReadLcmLog(log, "fuzz.lcm", "", faultlab::paper::Bench());
  Require(record.ok() || !record.error().message.empty());
  (void)SealedRig({data, size});
  Require(!OpenSealed({data, size}, "c", "rig", RigKey{}).has_value());
  if (size > 0) CheckOne(data[0], Bytes(data + 1, data + size), AllMessages());
  return 0;
}
