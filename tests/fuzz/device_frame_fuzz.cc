// What a device sends, in pieces as a line delivers them: a serial line and TCP. The first byte
// determines their length.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "hardware/device/frame.h"
#include "hardware/device/messages.h"
#include "hardware/io_error.h"

using namespace faultlab::hardware;  // NOLINT(google-build-using-namespace)

namespace {

void Take(Framing& framing, std::span<const std::uint8_t> bytes, std::size_t step) {
  std::vector<Frame> frames;
  for (; !bytes.empty(); bytes = bytes.subspan(std::min(step, bytes.size()))) {
    framing.Take(bytes.first(std::min(step, bytes.size())), frames);
  }
  for (const Frame& frame : frames) {
    if (frame.payload.size() > Frame::kPayloadMax) std::abort();
    (void)ReadInfo(frame.payload);
    (void)ReadAck(frame.payload);
    (void)ReadSample(frame.payload);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t step = std::max<std::size_t>(1, data[0]);
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  Take(*MakeCobsFraming(), bytes, step);
  try {
    Take(*MakeLengthFraming(), bytes, step);
  } catch (const IoError&) {  // of a length that no frame has
  }
  return 0;
}
