#include "server/lab/rehearsal/rehearsal.h"

#include <gtest/gtest.h>

namespace faultlab::server::lab {
namespace {

/// ctest runs a quarter of the published 10^6 steps per seed, `faultlab admin rehearse` all of
/// them.
constexpr std::int64_t kSteps = 250'000;

TEST(Rehearsal, NeverAllocatesTwiceNorAcceptsAStaleCommandInRandomWorlds) {
  std::int64_t tried = 0;
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const RehearsalReport report = Rehearse({.steps = kSteps, .seed = seed, .weeks = 0});
    EXPECT_EQ(report.steps, kSteps);
    EXPECT_EQ(report.double_allocations, 0) << seed << ": " << report.first_broken;
    EXPECT_EQ(report.broken_invariants, 0) << seed << ": " << report.first_broken;
    EXPECT_EQ(report.stale_commands_accepted, 0) << seed;
    EXPECT_GT(report.commands_accepted, 100) << "the fence must not refuse everything";
    EXPECT_GT(report.crashes, 10);
    EXPECT_GT(report.quarantines, 10);
    EXPECT_GT(report.clock_jumps, 10);
    tried += report.stale_commands_tried;
  }
  EXPECT_GT(tried, 10'000);
}

TEST(Rehearsal, GivesTheSameFiguresForTheSameSeed) {
  const RehearsalOptions options{.steps = 3000, .seed = 77, .weeks = 0};
  EXPECT_EQ(ToJson(Rehearse(options)), ToJson(Rehearse(options)));
  EXPECT_NE(ToJson(Rehearse(options)), ToJson(Rehearse({.steps = 3000, .seed = 78, .weeks = 0})));
}

TEST(Rehearsal, SharesFairlyAndKeepsItsEstimatesInSimulatedWeeks) {
  const RehearsalReport report = Rehearse({.steps = 0, .seed = 5, .weeks = 4});
  EXPECT_GE(report.jain, 0.95);
  EXPECT_GE(report.days_estimate_held, 0.95);
  EXPECT_GT(report.ours.utilisation, report.fifo_slots.utilisation);
  EXPECT_LT(report.ours.median_wait_min, report.fifo_slots.median_wait_min);
  EXPECT_LT(report.ours.no_show_loss, report.fifo_slots.no_show_loss);
}

}  // namespace
}  // namespace faultlab::server::lab
