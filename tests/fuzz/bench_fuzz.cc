// Descriptions of benches: what is accepted can be simulated, judged and told apart from others;
// what is refused is refused with the file's name.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/signals/excitation.h"
#include "hardware/bench/bench_reader.h"
#include "hardware/run_forecast.h"
#include "tests/fuzz/fuzz_input.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

namespace {

void RequireParts(const core::Bench& bench) {
  std::set<std::string> symbols;
  std::set<int> parameters;
  std::set<int> lines;
  Require(!bench.parts.empty() && bench.component_count() <= core::kComponentsMax);
  for (const core::ComponentInfo& part : bench.parts) {
    Require(symbols.insert(part.symbol).second && parameters.insert(part.parameter).second);
    Require(part.coupled < 0 || parameters.insert(part.coupled).second);
    Require(part.nominal > 0.0 && part.value_min < part.value_max);
    for (const core::SwitchPosition& position : part.positions) {
      Require(position.line >= 0 && position.line < 32 && lines.insert(position.line).second);
    }
    for (const double value : part.offered) {
      Require(value >= part.value_min && value <= part.value_max);
    }
  }
}

void RequireRun(const core::Bench& bench) {
  constexpr int kSamples = 20;
  auto uc_v = core::Generate(bench.excitation, 20.0, bench.period_s);
  Require(uc_v.ok());
  uc_v.value().resize(kSamples);
  for (const hardware::SignalForecast& signal :
       hardware::ForecastRun(bench, uc_v.value()).signals) {
    Require(!signal.name.empty() && signal.reaches.min <= signal.reaches.max);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto bench = hardware::ReadBench(text, "f.toml");
  if (!bench.ok()) {
    Require(bench.error().message.starts_with("f.toml"));
    return 0;
  }
  Require(bench.value().text == text);
  RequireParts(bench.value());
  RequireRun(bench.value());
  return 0;
}
