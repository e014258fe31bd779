#include "core/calibration/bench_noise.h"

namespace faultlab::core {

NoiseLevel NoiseOf(const Bench& bench) {
  return {bench.um.noise,
          bench.ia.noise,
          bench.n.noise * RadPerSecondOfRpm(bench.nominal.gear_ratio),
          bench.norm.friction_noise_nm,
          bench.norm.friction_tau_s,
          PassageNoise(bench.norm.mc_nm, bench.nominal.j_kg_m2, bench.period_s)};
}

NoiseLevel NoiseOf(const BenchProfile& profile, double gear_ratio) {
  return {profile.noise.um_v,
          profile.noise.ia_a,
          profile.noise.n_rpm * RadPerSecondOfRpm(gear_ratio),
          profile.friction.noise_rms_nm,
          profile.friction.noise_tau_s};
}

}  // namespace faultlab::core
