#include <gtest/gtest.h>

#include "server/api/metrics_text.h"
#include "server/api/rig_json.h"

namespace faultlab::server {
namespace {

TEST(MetricsText, AddsUpTheBucketsOfAHistogramAndEndsInInfinity) {
  hardware::TimeHistogram histogram;
  histogram.Count(15e-6);
  histogram.Count(0.0105);
  histogram.Count(2.0);
  MetricsText out;
  out.AddHistogram("faultlab_rig_command_seconds", histogram, Label("rig", "a\"b"));
  const std::string text = out.Take();
  const auto has = [&](const std::string& line) { return text.find(line + "\n") != text.npos; };
  EXPECT_TRUE(has("# TYPE faultlab_rig_command_seconds histogram")) << text;
  EXPECT_TRUE(has(R"(faultlab_rig_command_seconds_bucket{rig="a\"b",le="2e-05"} 1)")) << text;
  EXPECT_TRUE(has(R"(faultlab_rig_command_seconds_bucket{rig="a\"b",le="0.01"} 1)")) << text;
  EXPECT_TRUE(has(R"(faultlab_rig_command_seconds_bucket{rig="a\"b",le="0.011"} 2)")) << text;
  EXPECT_TRUE(has(R"(faultlab_rig_command_seconds_bucket{rig="a\"b",le="+Inf"} 3)")) << text;
  EXPECT_TRUE(has(R"(faultlab_rig_command_seconds_count{rig="a\"b"} 3)")) << text;
}

TEST(Calibration, IsAsOldAsTheDateThatItsTextBeginsWith) {
  using namespace std::chrono;
  const WallTime now(sys_days(2026y / November / 21) + hours(23));
  EXPECT_EQ(CalibrationAgeDays("2026-11-20 v1", now), 1);
  EXPECT_EQ(CalibrationAgeDays("2025-11-21", now), 365);
  EXPECT_EQ(CalibrationAgeDays("version 7", now), std::nullopt);
  EXPECT_EQ(CalibrationAgeDays("2026-13-01", now), std::nullopt);
}

}  // namespace
}  // namespace faultlab::server
