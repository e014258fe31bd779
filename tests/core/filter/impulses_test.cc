#include "core/filter/impulses.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/core/bench_records.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

constexpr ImpulseRule kRare{.gate = 12.0, .share_max = 0.02};

/// A quarter of a second, as little as hypotheses are fitted to, with impulses in um.
std::vector<Observation> ShortStretch(const std::vector<std::size_t>& impulses_at) {
  auto record = Between(BenchRecord({}, 43), 0.5, 0.77);
  for (const std::size_t at : impulses_at) record[at].um_v += 2.0;
  return MakeObservations(record, paper::Bench().readings(), Channels::kAll, 0.01, 10.0);
}

PredictionModel Model() {
  RigParameters rig = paper::Rig();
  rig.mc_nm = 0.33e-3;
  return MakePredictionModel(rig, paper::Noise(), 0.01);
}

TEST(LeaveOutImpulses, LeavesOutOneOfHoweverFewReadings) {
  std::vector<Observation> stretch = ShortStretch({12});
  EXPECT_EQ(LeaveOutImpulses(Model(), stretch, kRare), 1U);
  for (std::size_t k = 0; k < stretch.size(); ++k) EXPECT_EQ(stretch[k].mask, k == 12 ? 6 : 7) << k;
}

TEST(LeaveOutImpulses, LeavesNothingOutWhereManyAreFarOff) {
  std::vector<Observation> stretch = ShortStretch({8, 12, 17, 21});
  EXPECT_EQ(LeaveOutImpulses(Model(), stretch, kRare), 0U);
  for (const Observation& each : stretch) EXPECT_EQ(each.mask, 7);
}

}  // namespace
}  // namespace faultlab::core
