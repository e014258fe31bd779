// A program: how strong a disguise of a sealed record may be before it is not found again, how
// many records of strangers are taken for a copy, and how long a search takes. A minute of CPU
// time.
#include <chrono>
#include <cstdio>
#include <vector>

#include "core/fingerprint/record_index.h"
#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "hardware/bench/benches.h"
#include "tests/core/fingerprint/disguise.h"

namespace faultlab::core {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kPeriodS = 0.01;
constexpr int kRecords = 250;  // of a class
const OwnNoise kOwn = {15e-3, 15e-3, 1e-3, 0.5};

double MillisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// A run of the paper's bench: one of five parts fails at 10 s, or none.
std::vector<Sample> RecordOf(std::uint64_t seed, std::uint64_t prbs_seed = 1, int samples = 2000) {
  struct Change {
    const char* part;
    double value;
  };
  constexpr Change kPool[] = {
      {"R9", 33e3}, {"R1", 10.0}, {"Ra", 6.0}, {"J", 1.6e-5}, {"R12", 15e3}};
  const Bench& bench = hardware::PaperBench();
  std::vector<Fault> faults;
  if (seed % 6 < 5) {
    Fault fault;
    fault.component = *bench.Find(kPool[seed % 6].part);
    fault.value = kPool[seed % 6].value;
    fault.at_s = 10.0;
    faults.push_back(fault);
  }
  PrbsSpec spec;
  spec.seed = prbs_seed;
  const BenchProfile& profile = bench.profiles.front();
  return SimulateRecord(
      profile, bench.nominal, MakePrbs(spec, samples, kPeriodS), faults, seed, kPeriodS);
}

void PrintCurve(const RecordIndex& index, const std::vector<std::vector<Sample>>& records) {
  constexpr int kCopies = 200;
  std::printf("found of %d copies, all changes at random; um alone in half of them\n", kCopies);
  std::printf("strength      2 s    4 s    8 s   15 s\n");
  for (const double strength : {0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0}) {
    std::printf("%8.2f", strength);
    for (const std::size_t samples : {200U, 400U, 800U, 1500U}) {
      Random random(samples);
      int found = 0;
      for (int copy = 0; copy < kCopies; ++copy) {
        const std::size_t id = random.Below(records.size());
        Disguise disguise = DrawDisguise(2000, samples, strength, random);
        const auto copies = index.Find(Dress(records[id], disguise, kOwn, kPeriodS, random)).copies;
        if (!copies.empty() && copies.front().id == static_cast<std::int64_t>(id)) ++found;
      }
      std::printf("  %5d", found);
    }
    std::printf("\n");
  }
}

void PrintStrangers(const RecordIndex& index) {
  constexpr std::uint64_t kStrangers = 1000;
  int taken = 0;
  for (std::uint64_t seed = 0; seed < kStrangers; ++seed) {
    if (!index.Find(RecordOf(1'000'000 + seed, seed % 2 + 1)).copies.empty()) ++taken;
  }
  std::printf("strangers taken for a copy: %d of %d (half of them with the class's voltages)\n",
              taken,
              static_cast<int>(kStrangers));
}

/// Records of a large lab: of noise alone, which costs as much as any.
void PrintSearch() {
  constexpr int kMany = 100'000;
  constexpr int kSamples = 400;
  RecordIndex index;
  std::vector<Sample> record = RecordOf(1, 1, kSamples);
  for (Sample& sample : record) sample.ua_v = sample.ia_a = sample.n_rpm = kAbsent;
  Random random(1);
  for (int id = 0; id < kMany; ++id) {
    for (Sample& sample : record) sample.um_v = 2.0 * sample.uc_v + kOwn[0] * random.Normal();
    index.Put(id, record);
  }
  const std::vector<Sample> brought(record.begin() + 100, record.begin() + 300);
  const Clock::time_point begin = Clock::now();
  const auto copies = index.Find(brought).copies;
  std::printf("search for 2 s, one channel, in %d records of %d s: %.0f ms, %s\n",
              kMany,
              kSamples / 100,
              MillisecondsSince(begin),
              !copies.empty() && copies.front().id == kMany - 1 ? "found" : "not found");
  RecordIndex own;  // where each student has designed voltages of their own
  for (std::uint64_t id = 0; id < 250; ++id) {
    own.Put(static_cast<std::int64_t>(id), RecordOf(id, 17 * id + 3));
  }
  const std::vector<Sample> stranger = RecordOf(4711, 9999);
  const Clock::time_point again = Clock::now();
  const bool found = !own.Find(stranger).copies.empty();
  std::printf("search for 20 s in 250 records of 250 commands: %.0f ms, %s\n",
              MillisecondsSince(again),
              found ? "found" : "not found");
}

int Main() {
  RecordIndex index;
  std::vector<std::vector<Sample>> records;
  for (int id = 0; id < kRecords; ++id) {
    records.push_back(RecordOf(static_cast<std::uint64_t>(id)));
    index.Put(id, records.back());
  }
  PrintCurve(index, records);
  PrintStrangers(index);
  PrintSearch();
  return 0;
}

}  // namespace
}  // namespace faultlab::core

int main() {
  return faultlab::core::Main();
}
