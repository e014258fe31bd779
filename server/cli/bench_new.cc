#include "server/cli/bench_new.h"

#include <string_view>

#include "hardware/bench/benches.h"
#include "hardware/bench/shipped_benches.h"
#include "server/cli/console.h"
#include "server/csv/file_io.h"

namespace faultlab::server {
int RunBenchNew(const BenchNewOptions& options) {
  std::string known;
  for (const hardware::ShippedBench& shipped : hardware::ShippedBenches()) {
    const core::Result<const core::Bench*> bench = hardware::LoadBench(std::string(shipped.name));
    if (!bench) return Fail(bench.error(), kExitFailure);
    const std::string structure(bench.value()->structure->name);
    if (structure != options.structure) {
      if (!known.ends_with(structure)) known += (known.empty() ? "" : ", ") + structure;
      continue;
    }
    const std::string_view text = shipped.text;
    if (options.output == "-") return Print(std::string(text));
    return Ended(WriteFile(options.output, std::string(text)));
  }
  PrintError("--structure '" + options.structure + "': expected one of " + known);
  return kExitBadInput;
}

}  // namespace faultlab::server
