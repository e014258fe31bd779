#include "core/plant/fault_schedule.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/types/check.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

constexpr double kPeriodS = 0.1;

TEST(FaultSchedule, AnAbruptFaultActsFromTheFirstSampleNotBeforeItsTime) {
  const FaultSchedule schedule({{.component = paper::kR1, .value = 10.0, .at_s = 0.3}},
                               paper::Plant());
  EXPECT_EQ(schedule.ValueAt(paper::kR1, 2 * kPeriodS), 1.0);
  EXPECT_EQ(schedule.ValueAt(paper::kR1, 3 * kPeriodS), 10.0);
  EXPECT_EQ(schedule.ValueAt(paper::kR1, 600.0), 10.0);
  EXPECT_EQ(schedule.ValueAt(paper::kR9, 600.0), 10e3);
}

TEST(FaultSchedule, ADriftIsLinearAndStays) {
  const FaultSchedule schedule({{.component = paper::kR9,
                                 .value = 18e3,
                                 .at_s = 5.0,
                                 .kind = FaultKind::kDrift,
                                 .until_s = 17.0}},
                               paper::Plant());
  EXPECT_EQ(schedule.ValueAt(paper::kR9, 4.9), 10e3);
  EXPECT_DOUBLE_EQ(schedule.ValueAt(paper::kR9, 11.0), 14e3);
  EXPECT_EQ(schedule.ValueAt(paper::kR9, 17.0), 18e3);
  EXPECT_EQ(schedule.ValueAt(paper::kR9, 20.0), 18e3);
}

TEST(FaultSchedule, AnIntermittentFaultLastsItsHalfOpenInterval) {
  const FaultSchedule schedule({{.component = paper::kR12,
                                 .value = 2e3,
                                 .at_s = 1.0,
                                 .kind = FaultKind::kIntermittent,
                                 .until_s = 2.0}},
                               paper::Plant());
  EXPECT_EQ(schedule.ValueAt(paper::kR12, 1.0), 2e3);
  EXPECT_EQ(schedule.ValueAt(paper::kR12, 1.9), 2e3);
  EXPECT_EQ(schedule.ValueAt(paper::kR12, 2.0), 10e3);
}

TEST(FaultSchedule, LeavesWhatAnOperatorCommandedUntilItsOwnFaultActs) {
  Plant plant(paper::Plant(), paper::Hardware(), 1);
  FaultSchedule schedule({{.component = paper::kR1, .value = 100.0, .at_s = 1.0}}, paper::Plant());
  schedule.Apply(0.0, plant);
  plant.Set(paper::kR1, 10.0);
  schedule.Apply(0.5, plant);
  EXPECT_EQ(plant.parameters().series_ohm, 10.0);
  schedule.Apply(1.0, plant);
  EXPECT_EQ(plant.parameters().series_ohm, 100.0);
  plant.Set(paper::kR1, 1.0);
  schedule.Apply(1.1, plant);
  EXPECT_EQ(plant.parameters().series_ohm, 1.0);
}

TEST(FaultSchedule, RefusalsNameTheField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Validate({.value = 0.0}).error().field, "value");
  EXPECT_EQ(Validate({.value = nan}).error().field, "value");
  EXPECT_EQ(Validate({.at_s = -1.0}).error().field, "at_s");
  EXPECT_EQ(Validate({.at_s = 5.0, .kind = FaultKind::kDrift, .until_s = 5.0}).error().field,
            "until_s");
  EXPECT_TRUE(Validate({.at_s = 5.0}).ok());
  EXPECT_THROW(FaultSchedule({{.value = -1.0}}, {}), ContractError);
}

}  // namespace
}  // namespace faultlab::core
