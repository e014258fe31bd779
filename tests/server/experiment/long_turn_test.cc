#include "server/experiment/long_turn.h"

#include <gtest/gtest.h>

#include <future>

namespace faultlab::server {
namespace {

using enum LongTurn::For;
constexpr LongTurn::Short kShort{1000, 10'000};
constexpr std::int64_t kLong = kShort.samples + 1;

TEST(LongTurn, IsHeldByOnePersonAtATimeAndShortOnesNeedNone) {
  LongTurn turn{kShort};
  auto first = turn.ForSamples(kLong, kPerson);
  ASSERT_TRUE(first.ok());
  EXPECT_NE(first.value(), nullptr);
  EXPECT_EQ(turn.ForSamples(kLong, kPerson).error().reason, LongTurn::kTaken);
  EXPECT_EQ(turn.ForText(kShort.text_bytes + 1).error().reason, LongTurn::kTaken);
  EXPECT_EQ(turn.ForSamples(kShort.samples, kPerson).value(), nullptr);
  EXPECT_EQ(turn.ForText(kShort.text_bytes).value(), nullptr);
  const LongTurn::Hold copy = first.value();
  first = LongTurn::Hold();
  EXPECT_FALSE(turn.ForSamples(kLong, kPerson).ok()) << "until its last copy is gone";
}

TEST(LongTurn, OfAJobKeepsNoPersonWaiting) {
  LongTurn turn{kShort};
  const auto job = turn.ForSamples(kLong, kJob);
  EXPECT_EQ(turn.ForSamples(kLong, kJob).error().reason, LongTurn::kTaken);
  EXPECT_TRUE(turn.IsTaken(kJob));
  EXPECT_FALSE(turn.IsTaken(kPerson));
  EXPECT_TRUE(turn.ForText(kShort.text_bytes + 1).ok());
}

TEST(LongTurn, GradingWaitsForItsLike) {
  LongTurn turn{kShort};
  auto held = turn.ForSamples(kLong, kGrading);
  auto next = std::async(std::launch::async, [&] { return turn.ForSamples(kLong, kGrading).ok(); });
  held = LongTurn::Hold();
  EXPECT_TRUE(next.get());
}

}  // namespace
}  // namespace faultlab::server
