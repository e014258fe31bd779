#include "server/methods/same_kind.h"

#include "core/calibration/bench_noise.h"
#include "core/isolability/isolability.h"
#include "core/signals/excitation.h"

namespace faultlab::server {

std::vector<std::vector<core::Component>> SameKinds(const core::Bench& bench,
                                                    core::Channels channels,
                                                    std::span<const core::FaultSize> faults) {
  std::vector<std::vector<core::Component>> kinds;
  for (const core::FaultSize& fault : faults) kinds.push_back({fault.component});
  constexpr int kInputs = 300;
  const auto input = core::Generate(bench.excitation, kInputs * bench.period_s, bench.period_s);
  if (faults.empty() || !input) return kinds;
  core::IsolabilityOptions options;
  options.bench = &bench;
  const core::BenchProfile& profile = bench.profiles.front();
  options.rig = {bench.nominal, 1.0, profile.delta_s, profile.friction.mc_nm};
  options.noise = core::NoiseOf(profile, bench.nominal.gear_ratio);
  options.channels = channels;
  options.period_s = bench.period_s;
  options.uc_v = input.value();
  options.faults.assign(faults.begin(), faults.end());
  const auto judged = core::AnalyseIsolability(options);
  if (!judged) {
    if (faults.size() == 1) return kinds;
    // One of them is refused: the others are judged without it.
    for (std::size_t i = 0; i < faults.size(); ++i) {
      kinds[i] = SameKinds(bench, channels, faults.subspan(i, 1)).front();
    }
    return kinds;
  }
  for (std::size_t i = 0; i < faults.size(); ++i) kinds[i] = judged.value().faults[i].group;
  return kinds;
}

}  // namespace faultlab::server
