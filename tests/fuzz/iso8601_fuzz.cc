// Times in requests: an accepted one is written and read back to the same millisecond.
#include "server/api/iso8601.h"
#include "tests/fuzz/fuzz_input.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::Text(data, size);
  const auto time = server::ParseIso8601(text, "/at");
  if (time.ok()) {
    const auto again = server::ParseIso8601(server::Iso8601(time.value()), "/at");
    Require(again.ok() && again.value() == time.value());
    Require(server::BasicIso8601(time.value()).size() == 16);
  } else {
    Require(!time.error().message.empty() && time.error().field == "/at");
  }
  (void)server::LeadingDate(text);
  return 0;
}
