#include "server/experiment/waiting_line.h"

#include <gtest/gtest.h>

namespace faultlab::server {
namespace {

using std::chrono::seconds;

TEST(WaitingLine, KeepsTheOrderInWhichPeopleAskedFirst) {
  WaitingLine line;
  MonotonicTime now{};
  EXPECT_EQ(line.Ask("paper", "ann", now), 0U);
  EXPECT_EQ(line.Ask("paper", "bob", now), 1U);
  EXPECT_EQ(line.Ask("paper", "eve", now), 2U);
  EXPECT_EQ(line.Ask("servo", "eve", now), 0U) << "a line for each bench";
  EXPECT_EQ(line.Ask("paper", "bob", now), 1U) << "asking again moves nobody";
  line.Leave("paper", "ann");
  EXPECT_EQ(line.Ask("paper", "eve", now), 1U);
  EXPECT_EQ(line.Ask("paper", "ann", now), 2U) << "who has left joins at the end";
  EXPECT_EQ(line.Length("paper", now), 3U);
}

TEST(WaitingLine, OthersPassWhoeverDoesNotAskAgain) {
  WaitingLine line;
  MonotonicTime now{};
  line.Ask("paper", "ann", now);
  line.Ask("paper", "bob", now);
  now += 2 * WaitingLine::AgainAfter(1);
  EXPECT_EQ(line.Ask("paper", "bob", now), 1U);
  now += 2 * WaitingLine::AgainAfter(1);
  EXPECT_EQ(line.Ask("paper", "bob", now), 0U);
  EXPECT_EQ(line.Length("paper", now), 1U);
  now += seconds(60);
  EXPECT_EQ(line.Ask("paper", "ann", now), 0U) << "her place was kept";
  EXPECT_EQ(line.Ask("paper", "bob", now), 1U);
  now += WaitingLine::kKeptFor + 4 * WaitingLine::AgainAfter(1);
  EXPECT_EQ(line.Ask("paper", "eve", now), 0U) << "both have left";
  EXPECT_EQ(line.Ask("paper", "ann", now), 1U);
}

TEST(WaitingLine, IsAskedOftenByWhoIsNextAndSeldomByALargeClass) {
  EXPECT_EQ(WaitingLine::AgainAfter(0), seconds(2));
  EXPECT_EQ(WaitingLine::AgainAfter(79), seconds(9));
  EXPECT_EQ(WaitingLine::AgainAfter(5000), seconds(10));
  double asked_per_s = 0.0;
  for (std::size_t before = 0; before < 250; ++before) {
    asked_per_s += 1.0 / static_cast<double>(WaitingLine::AgainAfter(before).count());
  }
  EXPECT_LT(asked_per_s, 40.0);
}

TEST(WaitingLine, HasAnEnd) {
  WaitingLine line;
  const MonotonicTime now{};
  for (std::size_t k = 0; k < WaitingLine::kLongest + 5; ++k) {
    line.Ask("paper", "caller " + std::to_string(k), now);
  }
  EXPECT_EQ(line.Length("paper", now), WaitingLine::kLongest);
  EXPECT_EQ(line.Ask("paper", "one more", now), WaitingLine::kLongest);
}

}  // namespace
}  // namespace faultlab::server
