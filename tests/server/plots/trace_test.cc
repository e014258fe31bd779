#include "server/plots/trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace faultlab::server {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

PlotScale Scale(int width, double x_to) {
  return {{0, 0, width, 100}, {0.0, x_to}, {0.0, 1.0}};
}

TEST(Trace, BreaksAtNan) {
  Series series;
  series.x = {0, 1, 2, 3, 4};
  series.y = {0, 1, kNan, 1, 0};
  const auto traces = MakeTraces(series, Scale(100, 4.0));
  ASSERT_EQ(traces.size(), 2u);
  EXPECT_EQ(traces[0].size(), 2u);
  EXPECT_EQ(traces[1].front().x, 75.0);
  EXPECT_EQ(traces[1].front().y, 0.0) << "y runs upward";
}

TEST(Trace, KeepsEveryPeakOfADenseSignal) {
  Series series;
  constexpr int kPoints = 100'000;
  for (int k = 0; k < kPoints; ++k) {
    series.x.push_back(k);
    series.y.push_back(k == 54'321 ? 1.0 : k == 777 ? 0.0 : 0.5);
  }
  const auto traces = MakeTraces(series, Scale(200, kPoints));
  ASSERT_EQ(traces.size(), 1u);
  EXPECT_LE(traces[0].size(), 4u * 200u);
  const auto [high, low] = std::minmax_element(
      traces[0].begin(), traces[0].end(), [](auto& a, auto& b) { return a.y < b.y; });
  EXPECT_EQ(high->y, 0.0);
  EXPECT_EQ(low->y, 100.0);
  EXPECT_TRUE(std::is_sorted(
      traces[0].begin(), traces[0].end(), [](auto& a, auto& b) { return a.x < b.x; }));
}

TEST(Trace, GivesAStairItsCorners) {
  Series series;
  series.stair = true;
  series.x = {0, 50, 100};
  series.y = {0, 1, 1};
  const auto traces = MakeTraces(series, Scale(100, 100.0));
  ASSERT_EQ(traces.size(), 1u);
  ASSERT_EQ(traces[0].size(), 4u);
  EXPECT_EQ(traces[0][1].x, 50.0);
  EXPECT_EQ(traces[0][1].y, 100.0) << "holds the old value up to the step";
  EXPECT_EQ(traces[0][2].y, 0.0);
}

}  // namespace
}  // namespace faultlab::server
