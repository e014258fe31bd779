#include "server/storage/rig_calibrations.h"

#include <gmock/gmock.h>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server {
namespace {

using testing::IsEmpty;

class RigCalibrationsTest : public testing::TestWithParam<Engine> {
 protected:
  RigCalibration Calibration(const std::string& rig, int number) {
    return {.rig = rig,
            .run = rig + "-run-" + std::to_string(number),
            .bench = "paper-1",
            .at = WallTime{std::chrono::milliseconds{1'770'000'000'000 + number}},
            .json = R"({"number":)" + std::to_string(number) + "}"};
  }
  tests::TestDatabase database_{GetParam()};
  RigCalibrations calibrations_{*database_};
};

TEST_P(RigCalibrationsTest, KeepsTheNewestHundredOfEachRig) {
  EXPECT_THAT(calibrations_.List("a", "paper-1", 10).value(), IsEmpty());
  for (int i = 0; i < RigCalibrations::kKept + 5; ++i) {
    ASSERT_TRUE(calibrations_.Add(Calibration("a", i)).ok());
  }
  ASSERT_TRUE(calibrations_.Add(Calibration("b", 1)).ok());
  const std::vector<RigCalibration> all = calibrations_.List("a", "paper-1", 500).value();
  ASSERT_EQ(all.size(), static_cast<std::size_t>(RigCalibrations::kKept));
  EXPECT_EQ(all.front().json, R"({"number":104})");
  EXPECT_EQ(all.front().run, "a-run-104");
  EXPECT_EQ(all.front().at, Calibration("a", 104).at);
  EXPECT_EQ(all.back().run, "a-run-5");
  EXPECT_EQ(calibrations_.List("a", "paper-1", 3).value().size(), 3u);
  EXPECT_EQ(calibrations_.List("b", "paper-1", 500).value().size(), 1u);
  EXPECT_THAT(calibrations_.List("b", "servo-1", 500).value(), IsEmpty())
      << "what the rig was before says nothing of it";
}

INSTANTIATE_TEST_SUITE_P(Engines, RigCalibrationsTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server
