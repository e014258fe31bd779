// Settings of a server and of a bench: values in their ranges, or a refusal that names the line.
#include <cmath>

#include "hardware/config/bench_file.h"
#include "server/config.h"
#include "tests/fuzz/fuzz_input.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input input(data, size);
  const bool bench = input.Byte() % 2 == 0;
  const std::string_view text = input.Rest();
  if (bench) {
    const auto file = hardware::ParseBenchFile(text, "f.toml");
    Require(file.ok() || file.error().message.starts_with("f.toml"));
    if (file.ok()) Require(std::isfinite(file.value().ride_through_s));
  } else {
    const auto config = server::ParseConfig(text, "f.toml");
    Require(config.ok() || config.error().message.starts_with("f.toml"));
    if (config.ok()) Require(config.value().sim_rigs >= 0 && config.value().runs_max > 0);
  }
  return 0;
}
