#include <gtest/gtest.h>

#include <boost/json/serialize.hpp>

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

RigStatus Tripped() {
  RigStatus rig;
  rig.description.id = "bench-1";
  rig.trip = hardware::Trip{.name = "over_current",
                            .value = 2.625,
                            .limit = 2.0,
                            .index = 4711,
                            .t_s = 47.11,
                            .text = "2.625 A"};
  rig.loop.lateness.Count(1e-5);
  rig.loop.actuation.Count(0.0105);
  return rig;
}

TEST(RigJson, TellsOperatorsAloneWhatTrippedARigAndHowItsCommandsWent) {
  const auto all = RigToJson(Tripped(), {}, RigReader::kOperator);
  EXPECT_EQ(all.at("trip").at("value"), 2.625);
  EXPECT_EQ(all.at("trip").at("index"), 4711);
  EXPECT_EQ(all.at("loop").at("commands"), 1);
  EXPECT_EQ(all.at("health"), "over_current: 2.625 A");
  const auto some = RigToJson(Tripped(), {}, RigReader::kAnybody);
  for (const char* told : {"value", "index", "t_s"})
    EXPECT_TRUE(some.at("trip").at(told).is_null());
  EXPECT_TRUE(some.at("loop").is_null());
  EXPECT_EQ(boost::json::serialize(some).find("2.625"), std::string::npos);
  EXPECT_EQ(some.at("trip").at("name"), "over_current");
}

TEST(RigMetrics, CountNoCommandsOfARigInUse) {
  const auto text = [](const RigStatus& rig) {
    MetricsText out;
    AddRigMetrics(out, {rig});
    return out.Take();
  };
  const std::string command = "faultlab_rig_command_seconds";
  RigStatus rig = Tripped();
  EXPECT_NE(text(rig).find(command), std::string::npos);
  for (const auto state : {hardware::RigState::kArmed, hardware::RigState::kRunning}) {
    rig.state = state;
    EXPECT_EQ(text(rig).find(command), std::string::npos);
  }
  rig.state = hardware::RigState::kIdle;
  rig.leased = true;
  EXPECT_EQ(text(rig).find(command), std::string::npos);
  EXPECT_NE(text(rig).find("faultlab_rig_lateness_seconds"), std::string::npos);
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
