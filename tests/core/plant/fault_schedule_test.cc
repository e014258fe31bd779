#include "core/plant/fault_schedule.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/types/check.h"

namespace faultlab::core {
namespace {

constexpr double kPeriodS = 0.1;

TEST(FaultSchedule, AnAbruptFaultActsFromTheFirstSampleNotBeforeItsTime) {
  const FaultSchedule schedule({{.component = Component::kR1, .value = 10.0, .at_s = 0.3}}, {});
  EXPECT_EQ(schedule.ValueAt(Component::kR1, 2 * kPeriodS), 1.0);
  EXPECT_EQ(schedule.ValueAt(Component::kR1, 3 * kPeriodS), 10.0);
  EXPECT_EQ(schedule.ValueAt(Component::kR1, 600.0), 10.0);
  EXPECT_EQ(schedule.ValueAt(Component::kR9, 600.0), 10e3);
}

TEST(FaultSchedule, ADriftIsLinearAndStays) {
  const FaultSchedule schedule({{.component = Component::kR9,
                                 .value = 18e3,
                                 .at_s = 5.0,
                                 .kind = FaultKind::kDrift,
                                 .until_s = 17.0}},
                               {});
  EXPECT_EQ(schedule.ValueAt(Component::kR9, 4.9), 10e3);
  EXPECT_DOUBLE_EQ(schedule.ValueAt(Component::kR9, 11.0), 14e3);
  EXPECT_EQ(schedule.ValueAt(Component::kR9, 17.0), 18e3);
  EXPECT_EQ(schedule.ValueAt(Component::kR9, 20.0), 18e3);
}

TEST(FaultSchedule, AnIntermittentFaultLastsItsHalfOpenInterval) {
  const FaultSchedule schedule({{.component = Component::kR12,
                                 .value = 2e3,
                                 .at_s = 1.0,
                                 .kind = FaultKind::kIntermittent,
                                 .until_s = 2.0}},
                               {});
  EXPECT_EQ(schedule.ValueAt(Component::kR12, 1.0), 2e3);
  EXPECT_EQ(schedule.ValueAt(Component::kR12, 1.9), 2e3);
  EXPECT_EQ(schedule.ValueAt(Component::kR12, 2.0), 10e3);
}

TEST(FaultSchedule, LeavesWhatAnOperatorCommandedUntilItsOwnFaultActs) {
  Plant plant(PlantParameters{}, BenchProfileBench(), 1);
  FaultSchedule schedule({{.component = Component::kR1, .value = 100.0, .at_s = 1.0}}, {});
  schedule.Apply(0.0, plant);
  plant.Set(Component::kR1, 10.0);
  schedule.Apply(0.5, plant);
  EXPECT_EQ(plant.parameters().r1_ohm, 10.0);
  schedule.Apply(1.0, plant);
  EXPECT_EQ(plant.parameters().r1_ohm, 100.0);
  plant.Set(Component::kR1, 1.0);
  schedule.Apply(1.1, plant);
  EXPECT_EQ(plant.parameters().r1_ohm, 1.0);
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
