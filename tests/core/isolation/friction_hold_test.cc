#include "core/isolation/friction_hold.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

RigParameters RigOf(const PlantParameters& plant, double mc_nm) {
  RigParameters rig;
  rig.plant = plant;
  rig.mc_nm = mc_nm;
  return rig;
}

TEST(HardlyTurns, WhereFrictionTakesMuchOfTheDriveOfBothDirections) {
  PlantParameters plant = paper::Plant();
  const std::array<Observation, 3> both = {
      Observation{.u = -1.0}, Observation{.u = 2.0}, Observation{.u = 1.0}};
  const double torque_nm =
      plant.kt_nm_per_a * plant.gain() * 2.0 / (plant.ra_ohm + plant.series_ohm);
  EXPECT_TRUE(HardlyTurns(RigOf(plant, 0.41 * torque_nm), both));
  EXPECT_FALSE(HardlyTurns(RigOf(plant, 0.39 * torque_nm), both));
}

TEST(HardlyTurns, WhereItIsDrivenOneWay) {
  const PlantParameters plant = paper::Plant();
  const std::array<Observation, 2> one = {Observation{.u = 1.0}, Observation{.u = 2.0}};
  const std::array<Observation, 2> back = {Observation{.u = -2.0}, Observation{.u = -1.0}};
  const double torque_nm =
      plant.kt_nm_per_a * plant.gain() * 2.0 / (plant.ra_ohm + plant.series_ohm);
  for (const auto& drive : {one, back}) {
    EXPECT_TRUE(HardlyTurns(RigOf(plant, 0.41 * torque_nm), drive));
    EXPECT_FALSE(HardlyTurns(RigOf(plant, 0.39 * torque_nm), drive));
  }
  EXPECT_FALSE(HardlyTurns(RigOf(plant, 1.0), {}));
}

TEST(IsAlikeNearRest, WhatLeavesHardlyMoreOfWhatIsNoNoise) {
  const auto leaving = [](double score) {
    HypothesisFit fit;
    fit.count = 200;
    fit.chi2 = score * fit.count;
    return fit;
  };
  for (const double noise : {0.3, 1.0}) {
    EXPECT_TRUE(IsAlikeNearRest(leaving(noise), leaving(1.19), false));
    EXPECT_FALSE(IsAlikeNearRest(leaving(noise), leaving(1.21), false));
  }
  EXPECT_TRUE(IsAlikeNearRest(leaving(3.0), leaving(4.19), false));
  EXPECT_FALSE(IsAlikeNearRest(leaving(3.0), leaving(4.21), false));
  EXPECT_TRUE(IsAlikeNearRest(leaving(3.0), leaving(5.9), true));
  EXPECT_FALSE(IsAlikeNearRest(leaving(3.0), leaving(6.1), true));
}

}  // namespace
}  // namespace faultlab::core
