// The cost of one simulated sample, and the number of rigs that one core simulates at 100 Hz.
#include <benchmark/benchmark.h>

#include <vector>

#include "core/plant/converters.h"
#include "core/plant/plant.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "core/signals/random.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

constexpr double kRateHz = 100.0;

std::vector<double> PaperInput() {
  return MakePrbs(PrbsSpec{}, 2000, paper::kPeriodS);
}

void BM_Normal(benchmark::State& state) {
  Random random(1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(random.Normal());
  }
}
BENCHMARK(BM_Normal);

// One sample: write the input, advance to the reading, read with noise, advance to the next.
void RunSamples(benchmark::State& state, const BenchProfile& profile, const PlantParameters& p) {
  Plant plant(p, profile, 1);
  MeasurementNoise noise(profile.noise, 2);
  const std::vector<double> uc_v = PaperInput();
  Sample sample;
  std::size_t k = 0;
  for (auto _ : state) {
    plant.SetInput(uc_v[k]);
    k = k + 1 == uc_v.size() ? 0 : k + 1;
    plant.Advance(profile.delta_s);
    Acquire(plant.outputs(), paper::Hardware().converters, paper::kGearRatio, noise, sample);
    plant.Advance(paper::kPeriodS - profile.delta_s);
    benchmark::DoNotOptimize(sample);
  }
  state.counters["rigs_per_core"] = benchmark::Counter(
      static_cast<double>(state.iterations()) / kRateHz, benchmark::Counter::kIsRate);
}

void BM_BenchSample(benchmark::State& state) {
  RunSamples(state, paper::Hardware(), paper::Plant());
}
BENCHMARK(BM_BenchSample);

void BM_MultisimSample(benchmark::State& state) {
  RunSamples(state, paper::CircuitSimulation(), paper::Plant());
}
BENCHMARK(BM_MultisimSample);

void BM_OscillatingMotorSample(benchmark::State& state) {
  PlantParameters p = paper::Plant();
  p.j_kg_m2 = 1.43e-8;
  RunSamples(state, paper::Hardware(), p);
}
BENCHMARK(BM_OscillatingMotorSample);

// 1000 rigs side by side: their states no longer fit the first cache.
void BM_ManyRigsSample(benchmark::State& state) {
  const BenchProfile profile = paper::Hardware();
  const auto rigs = static_cast<std::size_t>(state.range(0));
  std::vector<Plant> plants;
  std::vector<MeasurementNoise> noises;
  for (std::size_t i = 0; i < rigs; ++i) {
    plants.emplace_back(paper::Plant(), profile, StreamSeed(1, i));
    noises.emplace_back(profile.noise, StreamSeed(2, i));
  }
  const std::vector<double> uc_v = PaperInput();
  std::size_t k = 0;
  Sample sample;
  for (auto _ : state) {
    for (std::size_t i = 0; i < rigs; ++i) {
      plants[i].SetInput(uc_v[(k + i) % uc_v.size()]);
      plants[i].Advance(profile.delta_s);
      Acquire(
          plants[i].outputs(), paper::Hardware().converters, paper::kGearRatio, noises[i], sample);
      plants[i].Advance(paper::kPeriodS - profile.delta_s);
      benchmark::DoNotOptimize(sample);
    }
    ++k;
  }
  state.counters["rigs_per_core"] = benchmark::Counter(
      static_cast<double>(state.iterations()) * static_cast<double>(rigs) / kRateHz,
      benchmark::Counter::kIsRate);
}
BENCHMARK(BM_ManyRigsSample)->Arg(1000);

void BM_PaperRecord(benchmark::State& state) {
  const std::vector<double> uc_v = PaperInput();
  const std::vector<Fault> faults = {{.component = paper::kR1, .value = 100.0}};
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        SimulateRecord(paper::Hardware(), paper::Plant(), uc_v, faults, 1, paper::kPeriodS));
  }
}
BENCHMARK(BM_PaperRecord);

void BM_Propagator(benchmark::State& state) {
  const LinearSystem system = MakeLinearSystem(paper::Plant(), 0.0, LinearRegime{});
  for (auto _ : state) {
    benchmark::DoNotOptimize(MakePropagator(system, 0.01));
  }
}
BENCHMARK(BM_Propagator);

}  // namespace
}  // namespace faultlab::core

BENCHMARK_MAIN();
