#include "core/isolation/onset.h"

#include <gtest/gtest.h>

#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

struct Change {
  RigParameters before = paper::Rig();
  RigParameters after = paper::Rig();
  NoiseLevel noise = paper::Noise();
};

Change Of(Component component, double value) {
  Change change;
  change.before.mc_nm = 0.33e-3;
  change.after = change.before;
  change.after.plant.Set(component, value);
  change.noise.w_rad_s = 0.5 * paper::kRadPerSecondOfRpm;
  return change;
}

std::vector<Observation> Stretch(const std::vector<Fault>& faults, std::uint64_t seed) {
  return MakeObservations(Between(BenchRecord(faults, seed, 6.0), 3.0, 6.0),
                          paper::Bench().readings(),
                          Channels::kAll,
                          0.01,
                          10.0);
}

TEST(EstimateOnset, FindsTheSampleOfALargeChange) {
  // Samples of the fault: it begins 1 s, 100 samples, after the start of the stretch.
  std::uint64_t seed = 131;
  for (double value : {0.741, 74.1}) {
    const Change c = Of(paper::kRa, value);
    const auto stretch = Stretch({AbruptFault(paper::kRa, value, 4.0)}, ++seed);
    EXPECT_NEAR(
        static_cast<double>(EstimateOnset(c.before, c.after, c.noise, 0.01, false, stretch, 110)),
        100.0,
        1.0)
        << value;
  }
}

TEST(EstimateOnset, KnowsThatACapacitorComesUncharged) {
  const Change c = Of(paper::kC8, 47e-6);
  const auto stretch = Stretch({AbruptFault(paper::kC8, 47e-6, 4.0)}, 134);
  EXPECT_NEAR(
      static_cast<double>(EstimateOnset(c.before, c.after, c.noise, 0.01, true, stretch, 120)),
      100.0,
      1.0);
}

TEST(EstimateOnset, SaysTheFirstCandidateOfAFaultThatWasThereAllAlong) {
  const Change c = Of(paper::kRa, 12.0);
  const auto stretch = Stretch({AbruptFault(paper::kRa, 12.0, 1.0)}, 135);
  EXPECT_LE(EstimateOnset(c.before, c.after, c.noise, 0.01, false, stretch, 120), 10U);
}

TEST(EstimateOnset, ReturnsTheLastWithoutACandidate) {
  const Change c = Of(paper::kRa, 12.0);
  EXPECT_EQ(EstimateOnset(c.before, c.after, c.noise, 0.01, false, {}, 7), 7U);
}

}  // namespace
}  // namespace faultlab::core
