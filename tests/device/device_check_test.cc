// What a device says of itself, held against the description of its bench.
#include "hardware/device/device_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hardware/io_error.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

using testing::HasSubstr;

constexpr std::uint32_t kNominal = 1u << 17 | 1u << 19 | 1u << 21 | 1u << 6;

DeviceInfo Info() {
  DeviceInfo info;
  info.version = kDeviceProtocol;
  info.capabilities = 0x3f;
  info.period_min_us = 2'000;
  info.period_max_us = 32'000;
  info.convert_us = 672;
  info.uc = info.um = {.step_nv = 1'220'703, .offset = 0, .bits = 12};
  info.uc_max = 4095;
  info.relay_lines = 0x00ff00ff;
  info.safe_lines = kNominal;
  info.make_first_lines = 1u << 6 | 1u << 7 | 1u << 22 | 1u << 23;
  return info;
}

std::string RefusalOf(const DeviceInfo& info) {
  BenchConfig config = ConfigOf(paper::Bench());
  try {
    CheckWiringOf(info, config, kNominal);
  } catch (const IoError& error) {
    return error.what();
  }
  return "";
}

TEST(DeviceCheck, RefusesADeviceThatCallsSomethingElseSafe) {
  EXPECT_EQ(RefusalOf(Info()), "");
  DeviceInfo info = Info();
  info.safe_lines = 1u << 16;
  EXPECT_THAT(RefusalOf(info), HasSubstr("the safe lines 0x00010000"));
  info = Info();
  info.make_first_lines = 0;
  EXPECT_THAT(RefusalOf(info), HasSubstr("make before they break"));
  info = Info();
  info.relay_lines = 0xff;
  EXPECT_THAT(RefusalOf(info), HasSubstr("relay lines 0x000000ff"));
  info = Info();
  info.capabilities = DeviceInfo::kIa;
  EXPECT_THAT(RefusalOf(info), HasSubstr("does not measure um"));
}

TEST(DeviceCheck, TakesOutWhatTheDeviceDoesNotMeasure) {
  DeviceInfo info = Info();
  info.capabilities = DeviceInfo::kUm | DeviceInfo::kEncoder;
  BenchConfig config = ConfigOf(paper::Bench());
  CheckWiringOf(info, config, kNominal);
  EXPECT_FALSE(config.description.has_ua);
  EXPECT_FALSE(config.description.has_ia);
  EXPECT_TRUE(config.description.has_n);
  EXPECT_EQ(config.scaling.speed, SpeedMethod::kGatedCount) << "no edge times";
}

TEST(DeviceCheck, NamesThePartOfAPlanThatTheDeviceCannotPlay) {
  const BenchConfig config = ConfigOf(paper::Bench());
  RunPlan plan;
  plan.uc_v = {2.0, 3.0};
  EXPECT_TRUE(CheckPlanOf(Info(), config, plan).ok());
  EXPECT_EQ(CodesOf(Info(), config, plan), (std::vector<std::int16_t>{1638, 2458}));
  plan.period_s = 0.05;
  EXPECT_EQ(CheckPlanOf(Info(), config, plan).error().field, "period_s");
  plan.period_s = 0.0097;
  EXPECT_THAT(CheckPlanOf(Info(), config, plan).error().message, HasSubstr("conversions"));
  plan.period_s = 0.01;
  plan.uc_v = {2.0, 5.1};
  EXPECT_EQ(CheckPlanOf(Info(), config, plan).error().field, "uc_v/1");
}

}  // namespace
}  // namespace faultlab::hardware
