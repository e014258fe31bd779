#include "server/experiment/long_turn.h"

#include <gtest/gtest.h>

#include <future>

namespace faultlab::server {
namespace {

using enum LongTurn::WhenTaken;
constexpr std::int64_t kLong = LongTurn::kShortSamplesMax + 1;

TEST(LongTurn, IsHeldByOneAtATimeAndShortOnesNeedNone) {
  LongTurn turn;
  auto first = turn.ForSamples(kLong, kRefuse);
  ASSERT_TRUE(first.ok());
  EXPECT_NE(first.value(), nullptr);
  EXPECT_EQ(turn.ForSamples(kLong, kRefuse).error().reason, "long_recording_waits");
  EXPECT_EQ(turn.ForText(LongTurn::kShortTextBytesMax + 1).error().reason, "long_recording_waits");
  EXPECT_EQ(turn.ForSamples(LongTurn::kShortSamplesMax, kRefuse).value(), nullptr);
  EXPECT_EQ(turn.ForText(LongTurn::kShortTextBytesMax).value(), nullptr);
  const LongTurn::Hold copy = first.value();
  first = LongTurn::Hold();
  EXPECT_FALSE(turn.ForSamples(kLong, kRefuse).ok()) << "until its last copy is gone";
}

TEST(LongTurn, IsGivenBackAndThoseWhoMayWaitGetIt) {
  LongTurn turn;
  auto held = turn.ForSamples(kLong, kRefuse);
  auto waiting = std::async(std::launch::async, [&] { return turn.ForSamples(kLong, kWait).ok(); });
  held = LongTurn::Hold();
  EXPECT_TRUE(waiting.get());
  EXPECT_TRUE(turn.ForText(LongTurn::kShortTextBytesMax + 1).ok());
}

}  // namespace
}  // namespace faultlab::server
