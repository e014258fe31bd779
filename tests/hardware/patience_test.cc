#include "hardware/daq/patience.h"

#include <gtest/gtest.h>

namespace faultlab::hardware {
namespace {

using std::chrono::milliseconds;

TEST(PatienceTest, EndsAfterItsLimitOfOrdinaryWaiting) {
  Patience patience{milliseconds(250)};
  int slices = 0;
  while (!patience.over()) {
    patience.Waited(patience.slice());
    ++slices;
  }
  EXPECT_EQ(slices, 10);
}

TEST(PatienceTest, CountsAStandstillOfTheProcessAsAtMostTwoSlices) {
  Patience patience{milliseconds(250)};
  patience.Waited(milliseconds(60'000));
  EXPECT_FALSE(patience.over());
  int slices = 0;
  for (; !patience.over(); ++slices) patience.Waited(patience.slice());
  EXPECT_EQ(slices, 8);
}

TEST(PatienceTest, IsOverAfterEnoughStandstillsInARow) {
  Patience patience{milliseconds(250)};
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(patience.over());
    patience.Waited(milliseconds(1'000));
  }
  EXPECT_TRUE(patience.over()) << "a machine that never runs is no better than a driver that hangs";
}

}  // namespace
}  // namespace faultlab::hardware
