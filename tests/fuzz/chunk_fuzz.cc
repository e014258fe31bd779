// Stored samples: a damaged chunk is refused, also if its checksum is right. An accepted chunk is
// written and read back bit for bit.
#include <zlib.h>

#include <cstring>
#include <span>
#include <vector>

#include "server/storage/chunk_codec.h"
#include "tests/fuzz/fuzz_input.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

namespace {

void Check(std::span<const std::byte> bytes) {
  const auto samples = server::DecodeChunk(bytes);
  if (!samples) return Require(!samples.error().message.empty());
  if (samples.value().empty()) return;
  const auto again = server::DecodeChunk(server::EncodeChunk(samples.value()));
  Require(again.ok() && again.value().size() == samples.value().size());
  for (std::size_t i = 0; i < samples.value().size(); ++i) {
    Require(std::memcmp(&samples.value()[i], &again.value()[i], sizeof(core::Sample)) == 0);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::byte> bytes(size);
  if (size > 0) std::memcpy(bytes.data(), data, size);
  Check(bytes);
  constexpr std::size_t kHead = 16;
  constexpr std::size_t kCrcAt = 12;
  if (size < kHead) return 0;
  constexpr unsigned char kMagic[] = {'F', 'L', 'C', 'H', 1, 0, 7, 0};
  std::memcpy(bytes.data(), kMagic, sizeof kMagic);
  bytes[10] = bytes[11] = std::byte{0};  // at most 65535 samples, to save time
  const auto crc = static_cast<std::uint32_t>(crc32(
      0, reinterpret_cast<const Bytef*>(bytes.data() + kHead), static_cast<uInt>(size - kHead)));
  for (std::size_t i = 0; i < 4; ++i) bytes[kCrcAt + i] = static_cast<std::byte>(crc >> 8 * i);
  Check(bytes);
  return 0;
}
