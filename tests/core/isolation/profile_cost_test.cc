#include "core/isolation/profile_cost.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tests/core/isolation/fault_stretch.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

TEST(ProfileCost, IsTheLowestCostOverTheFrictionTorqueWithItsPrior) {
  FaultStretch fault({AbruptFault(paper::kRa, 9.0, 1.0)}, 81);
  FitContext& context = fault.context;
  context.rig.mc_nm = 0.30e-3;  // off by 0.3 of its unit
  ProfileCost profile(context);
  const double cost = profile.At({paper::kRa, std::log(9.0)}, context.stretch);
  // The same by search: Mc in steps of 0.001 units around the rig's.
  double lowest = std::numeric_limits<double>::max();
  for (int i = -1000; i <= 1000; i += 5) {
    const double q = 1e-3 * i;
    RigParameters rig = WithComponent(context.rig, paper::kRa, 9.0);
    rig.mc_nm += q * paper::Rig().mc_unit_nm;
    const double prior = q * q * context.calibration.information(0, 0);
    const double tried = RunInnovations(context.ModelOf(rig), context.stretch).cost() + prior;
    lowest = std::min(lowest, tried);
  }
  EXPECT_NEAR(cost, lowest, 0.05);
}

TEST(ProfileCost, GivesPointsSideBySideTheCostsThatEachGetsAlone) {
  FaultStretch fault({AbruptFault(paper::kR1, 10.0, 1.0)}, 82);
  ProfileCost profile(fault.context);
  const std::array<ProfileCost::Point, 3> points = {
      {{paper::kR1, std::log(10.0)}, {paper::kJ, std::log(1e-5)}, {paper::kC8, std::log(1e-6)}}};
  const auto together = profile.At(points, fault.context.stretch);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(profile.At(points[i], fault.context.stretch), together[i].cost) << i;
    EXPECT_EQ(together[i].count, 600) << i;
  }
}

TEST(ProfileCost, RangesHoldNominalAndEveryRelayPosition) {
  const PlantParameters nominal = paper::Plant();
  for (Component component : paper::Parts()) {
    const ValueRange range = RangeOf(component);
    EXPECT_NEAR(std::exp(range.LogAt(0)), range.low, 1e-9 * range.low);
    EXPECT_NEAR(std::exp(range.LogAt(range.points - 1)), range.high, 1e-9 * range.high);
    if (component != paper::kC8) {
      EXPECT_LT(range.low, nominal.Get(component)) << Name(component);
    }
    EXPECT_GT(range.high, nominal.Get(component)) << Name(component);
    if (!IsSwitched(component)) continue;
    const std::vector<double> values = paper::RelayValues(component);
    for (std::size_t i = 1; i < values.size(); ++i) {
      EXPECT_LT(range.low, values[i]) << Name(component);
      EXPECT_GT(range.high, values[i]) << Name(component);
    }
  }
}

}  // namespace
}  // namespace faultlab::core
