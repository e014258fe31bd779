#include "core/diagnosis/fault_episodes.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

Verdict FaultAt(double t_s, std::vector<Component> group = {}) {
  Verdict verdict;
  verdict.kind = VerdictKind::kFault;
  verdict.detected_at_s = t_s;
  verdict.onset_s = t_s - 0.01;
  verdict.group = std::move(group);
  return verdict;
}

TEST(FaultEpisodes, ANewAlarmEndsTheOneBefore) {
  FaultEpisodes episodes;
  episodes.Open(FaultAt(10.0));
  Verdict named = FaultAt(10.0, {paper::kR1});
  episodes.Update(named, FaultShape::kAbrupt, 10.0);
  episodes.Open(FaultAt(15.0));
  Verdict other = FaultAt(15.0, {paper::kJ});
  episodes.Update(other, FaultShape::kAbrupt, 15.0);
  ASSERT_EQ(episodes.list().size(), 2U);
  EXPECT_EQ(episodes.list()[0].ended_at_s, 15.0);
  EXPECT_FALSE(episodes.list()[1].ended_at_s.has_value());
}

TEST(FaultEpisodes, TheSameComponentAgainIsOneEpisodeWithTheFirstDetection) {
  FaultEpisodes episodes;
  episodes.Open(FaultAt(10.0));
  Verdict named = FaultAt(10.0, {paper::kR9, paper::kR12});
  episodes.Update(named, FaultShape::kDrift, 10.0);
  episodes.Open(FaultAt(12.0));
  Verdict again = FaultAt(12.0, {paper::kR12});
  episodes.Update(again, FaultShape::kDrift, 12.0);
  ASSERT_EQ(episodes.list().size(), 1U);
  EXPECT_EQ(again.detected_at_s, 10.0);
  EXPECT_EQ(again.onset_s, 9.99);
  EXPECT_FALSE(episodes.list()[0].ended_at_s.has_value());
  // A later fit of the same alarm stays in the episode.
  Verdict later = FaultAt(12.0, {paper::kR12});
  episodes.Update(later, FaultShape::kDrift, 12.0);
  EXPECT_EQ(later.detected_at_s, 10.0);
  EXPECT_EQ(episodes.list().size(), 1U);
}

TEST(FaultEpisodes, KeepsTheDetectionOfEveryFurtherChangeOfAFault) {
  FaultEpisodes episodes;
  episodes.Open(FaultAt(8.0));
  Verdict named = FaultAt(8.0, {paper::kR12});
  episodes.Update(named, FaultShape::kAbrupt, 8.0);
  EXPECT_EQ(NewestChange(named), 7.99);
  for (const double t_s : {14.0, 17.0}) {
    episodes.Open(FaultAt(t_s));
    for (int fit = 0; fit < 3; ++fit) {  // each fit of an alarm is the same detection
      Verdict again = FaultAt(t_s, {paper::kR12});
      episodes.Update(again, FaultShape::kAbrupt, t_s);
      named = again;
    }
  }
  EXPECT_EQ(named.detected_at_s, 8.0);
  ASSERT_EQ(named.further.size(), 2U);
  EXPECT_EQ(named.further[0].detected_at_s, 14.0);
  EXPECT_EQ(named.further[0].onset_s, 13.99);
  EXPECT_EQ(named.further[1].detected_at_s, 17.0);
  EXPECT_EQ(NewestChange(named), 16.99) << "the value is that since the newest change";
  EXPECT_EQ(DetectionsOf(named).size(), 3U);
  EXPECT_EQ(episodes.list()[0].verdict.further.size(), 2U);
}

/// While the window fills, a return to nominal may look like another value of the same component.
TEST(FaultEpisodes, AWithdrawnFurtherChangeEndsTheFaultAndLeavesItsValue) {
  FaultEpisodes episodes;
  episodes.Open(FaultAt(8.0));
  Verdict named = FaultAt(8.0, {paper::kR12});
  named.reason = "the first value";
  episodes.Update(named, FaultShape::kAbrupt, 8.0);
  episodes.Open(FaultAt(14.0));
  Verdict early = FaultAt(14.0, {paper::kR12});
  early.reason = "of half a window";
  episodes.Update(early, FaultShape::kAbrupt, 14.0);
  episodes.Withdraw();
  ASSERT_EQ(episodes.list().size(), 1U);
  EXPECT_EQ(episodes.list()[0].verdict.reason, "the first value");
  EXPECT_EQ(episodes.list()[0].ended_at_s, 14.0);
  EXPECT_TRUE(episodes.list()[0].verdict.further.empty());
}

TEST(FaultEpisodes, AFaultThatMovesHasOneDetection) {
  FaultEpisodes episodes;
  episodes.Open(FaultAt(8.0));
  Verdict named = FaultAt(8.0, {paper::kR12});
  episodes.Update(named, FaultShape::kAbrupt, 8.0);
  Verdict farther = FaultAt(14.0, {paper::kR12});
  farther.reason = "where it is now";
  episodes.GoOn(farther);
  EXPECT_EQ(farther.detected_at_s, 8.0);
  EXPECT_TRUE(farther.further.empty());
  ASSERT_EQ(episodes.list().size(), 1U);
  EXPECT_EQ(episodes.list()[0].verdict.reason, "where it is now");
  EXPECT_EQ(episodes.list()[0].shape, FaultShape::kDrift);
  EXPECT_FALSE(episodes.list()[0].ended_at_s);
}

TEST(FaultEpisodes, AWithdrawnAlarmLeavesNothing) {
  FaultEpisodes episodes;
  episodes.Open(FaultAt(10.0));
  episodes.Withdraw();
  EXPECT_TRUE(episodes.list().empty());
  episodes.Open(FaultAt(20.0));
  EXPECT_EQ(episodes.list().size(), 1U);
}

}  // namespace
}  // namespace faultlab::core
