#include "server/plots/thinned.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace faultlab::server {
namespace {

Series Wave(int points) {
  Series series;
  for (int k = 0; k < points; ++k) {
    series.x.push_back(0.01 * k);
    series.y.push_back(std::sin(0.1 * k));
  }
  return series;
}

TEST(Thinned, LeavesAShortSeriesAsItIs) {
  EXPECT_EQ(Thinned(Wave(20'000), {}).y, Wave(20'000).y);
}

TEST(Thinned, KeepsEveryPeakOfALongOneAndItsEnds) {
  Series wave = Wave(1'000'000);
  wave.y[333'333] = 7.0;
  wave.y[777'777] = -8.0;
  const Series thin = Thinned(wave, {});
  EXPECT_LE(thin.x.size(), 16'004u);
  EXPECT_EQ(thin.x.size(), thin.y.size());
  EXPECT_TRUE(std::is_sorted(thin.x.begin(), thin.x.end()));
  EXPECT_EQ(thin.x.front(), wave.x.front());
  EXPECT_EQ(thin.x.back(), wave.x.back());
  const auto at = [&](double value) {
    return thin.x[static_cast<std::size_t>(std::ranges::find(thin.y, value) - thin.y.begin())];
  };
  EXPECT_EQ(at(7.0), wave.x[333'333]);
  EXPECT_EQ(at(-8.0), wave.x[777'777]);
}

TEST(Thinned, KeepsAGapAsOnePointAndALensWhole) {
  Series wave = Wave(1'000'000);
  for (std::size_t k = 500'000; k < 600'000; ++k) wave.y[k] = std::nan("");
  const Series thin = Thinned(wave, Inset{.x_from = 100.0, .x_to = 101.0});
  EXPECT_EQ(std::ranges::count_if(thin.y, [](double y) { return std::isnan(y); }), 1);
  EXPECT_EQ(std::ranges::count_if(thin.x, [](double x) { return x >= 100.0 && x <= 101.0; }), 101);
  EXPECT_LE(thin.x.size(), 16'200u);
}

}  // namespace
}  // namespace faultlab::server
