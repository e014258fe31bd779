#include "tests/world/rehearsal.h"

#include <gtest/gtest.h>

#include <utility>

#include "server/lab/lab_store.h"
#include "tests/support/postgres_cluster.h"
#include "tests/support/scale.h"
#include "tests/support/temp_folder.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

/// Of each of four seeds. The proof makes the published 10^6 steps.
const std::int64_t kSteps = tests::Proving() ? 250'000 : 10'000;

RehearsalReport Rehearsed(const RehearsalOptions& options) {
  auto report = Rehearse(options);
  EXPECT_TRUE(report.ok()) << report.error().message;
  return std::move(report).value();
}

void ExpectEveryRuleKept(const RehearsalReport& report, std::uint64_t seed) {
  for (const auto& [rule, found] : report.broken_rules) {
    ADD_FAILURE() << "seed " << seed << ": " << found.count << " of: " << found.first;
  }
}

TEST(Rehearsal, KeepsEveryPublishedRuleUnderFaults) {
  RehearsalReport all;
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const RehearsalReport report = Rehearsed({.steps = kSteps, .seed = seed, .weeks = 0});
    EXPECT_EQ(report.steps, kSteps);
    ExpectEveryRuleKept(report, seed);
    EXPECT_EQ(report.double_allocations, 0);
    EXPECT_EQ(report.stale_commands_accepted, 0);
    EXPECT_EQ(report.broken_invariants, 0);
    all.sessions += report.sessions;
    all.commands_accepted += report.commands_accepted;
    all.stale_commands_tried += report.stale_commands_tried;
    all.crashes += report.crashes;
    all.quarantines += report.quarantines;
    all.clock_jumps += report.clock_jumps;
  }
  EXPECT_GT(all.sessions, 500);
  EXPECT_GT(all.commands_accepted, 500) << "the fence must not refuse everything";
  EXPECT_GT(all.stale_commands_tried, 500);
  EXPECT_GT(all.crashes, 20);
  EXPECT_GT(all.quarantines, 20);
  EXPECT_GT(all.clock_jumps, 5);
}

TEST(Rehearsal, KeepsThemOnSqlite) {
  tests::TempFolder folder;
  ExpectEveryRuleKept(
      Rehearsed({.steps = 4000, .seed = 5, .weeks = 0, .database = folder.File("rehearsal.db")}),
      5);
}

TEST(Rehearsal, KeepsThemOnPostgresqlWithTwoMembers) {
  ExpectEveryRuleKept(Rehearsed({.steps = 1500,
                                 .seed = 6,
                                 .weeks = 0,
                                 .database = tests::PostgresCluster::Instance().CreateDatabase()}),
                      6);
}

TEST(Rehearsal, RefusesADatabaseInUse) {
  tests::TestDatabase database(Engine::kSqlite);
  ASSERT_TRUE(database
                  ->Write(Durability::kPromise,
                          [](Transaction& tx) -> core::Status {
                            Changes changes;
                            Rig rig;
                            rig.id = "bench-1";
                            changes.rigs.push_back(rig);
                            lab_store::Save(tx, changes, 1);
                            return core::Done{};
                          })
                  .ok());
  const auto refused =
      Rehearse({.steps = 10, .seed = 1, .weeks = 0, .database = database.options().location});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, core::ErrorCode::kConflict);
}

TEST(Rehearsal, GivesTheSameFiguresForTheSameSeed) {
  const RehearsalOptions options{.steps = 3000, .seed = 77, .weeks = 0};
  EXPECT_EQ(ToJson(Rehearsed(options)), ToJson(Rehearsed(options)));
  EXPECT_NE(ToJson(Rehearsed(options)), ToJson(Rehearsed({.steps = 3000, .seed = 78, .weeks = 0})));
}

TEST(Rehearsal, SharesFairlyAndKeepsItsEstimatesInSimulatedWeeks) {
  const RehearsalReport report =
      Rehearsed({.steps = 0, .seed = 5, .weeks = tests::Proving() ? 4 : 1});
  EXPECT_GE(report.jain, 0.95);
  EXPECT_GE(report.days_estimate_held, 0.95);
  EXPECT_GT(report.ours.utilisation, report.fifo_slots.utilisation);
  EXPECT_LT(report.ours.median_wait_min, report.fifo_slots.median_wait_min);
  EXPECT_LT(report.ours.no_show_loss, report.fifo_slots.no_show_loss);
}

}  // namespace
}  // namespace faultlab::server::lab
