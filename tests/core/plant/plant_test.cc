#include "core/plant/plant.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/signals/prbs.h"
#include "core/types/check.h"
#include "hardware/bench/benches.h"
#include "tests/core/plant/oracle.h"
#include "tests/paper_bench.h"
#include "tests/support/heap_guard.h"

namespace faultlab::core {
namespace {

constexpr double kPeriodS = 0.01;
constexpr double kDeltaS = 0.0095;
// Rounding error of a matrix exponential with up to 20 squarings.
constexpr double kExact = 1e-9;

BenchProfile Frictionless() {
  BenchProfile profile = paper::CircuitSimulation();
  profile.noise = {};
  return profile;
}

BenchProfile QuietBench() {
  BenchProfile profile = paper::Hardware();
  profile.friction.noise_rms_nm = 0.0;
  return profile;
}

TEST(Plant, SteadyStateIsThatOfTheEquations) {
  const PlantParameters p = paper::Plant();
  const BenchProfile profile = QuietBench();
  Plant plant(p, profile, 1);
  plant.SetInput(3.0);
  for (int k = 0; k < 200; ++k) {
    plant.Advance(kPeriodS);
  }
  // Uout = 2.4 * 3; Uout = (Ra+R1) i + Ke w, KT i = B w + Mc.
  const double ke_kt = p.ke_v_per_rad_s * p.kt_nm_per_a;
  const double r = p.ra_ohm + p.series_ohm;
  const double w =
      (7.2 * p.kt_nm_per_a - r * profile.friction.mc_nm) / (p.b_nm_per_rad_s * r + ke_kt);
  const PlantOutputs out = plant.outputs();
  EXPECT_NEAR(out.ua_v, 7.2, kExact);
  EXPECT_NEAR(out.omega_rad_s, w, kExact * w);
  EXPECT_NEAR(out.ia_a, (p.b_nm_per_rad_s * w + profile.friction.mc_nm) / p.kt_nm_per_a, kExact);
  EXPECT_NEAR(out.um_v, out.ua_v - p.series_ohm * out.ia_a, kExact);
}

TEST(Plant, StepLengthDoesNotMatterWhileTheMotorTurns) {
  for (const double j : {1.43e-8, 1.43e-6, 1.43e-4}) {
    PlantParameters p = paper::Plant();
    p.j_kg_m2 = j;
    Plant coarse(p, Frictionless(), 1);
    Plant fine(p, Frictionless(), 1);
    const std::vector<double> uc_v = MakePrbs({}, 100, kPeriodS);
    for (const double uc : uc_v) {
      coarse.SetInput(uc);
      fine.SetInput(uc);
      coarse.Advance(kPeriodS);
      for (int i = 0; i < 7; ++i) {
        fine.Advance(kPeriodS / 7);
      }
      EXPECT_NEAR(coarse.state()(2), fine.state()(2), 1e-8 * (1.0 + fine.state()(2))) << j;
      EXPECT_NEAR(coarse.state()(1), fine.state()(1), 1e-9) << j;
      EXPECT_NEAR(coarse.outputs().angle_rad, fine.outputs().angle_rad, 1e-8) << j;
    }
  }
}

struct OracleCase {
  const char* name;
  Component component;
  double value;
  int shape;
};

class PlantOracle : public ::testing::TestWithParam<OracleCase> {};
INSTANTIATE_TEST_SUITE_P(Faults,
                         PlantOracle,
                         ::testing::Values(OracleCase{"nominal", paper::kR1, 1.0, 2},
                                           OracleCase{"Tustin", paper::kR1, 1.0, 1},
                                           OracleCase{"NoStribeck", paper::kR1, 1.0, 0},
                                           OracleCase{"R1_100", paper::kR1, 100.0, 2},
                                           OracleCase{"R9_56k", paper::kR9, 56e3, 2},
                                           OracleCase{"C8_1u", paper::kC8, 1e-6, 2},
                                           OracleCase{"C8_47u", paper::kC8, 47e-6, 1},
                                           OracleCase{"Ra_74", paper::kRa, 74.1, 2},
                                           OracleCase{"J_small", paper::kJ, 1.43e-8, 2},
                                           OracleCase{"J_small_Tustin", paper::kJ, 1.43e-8, 1},
                                           OracleCase{"J_large", paper::kJ, 1.43e-4, 2},
                                           OracleCase{"B_large", paper::kB, 1.8e-4, 2}),
                         [](const auto& one) { return one.param.name; });

// From rest through break-away, the Stribeck region, running, and coasting to standstill and away
// again: an input that reaches every kind of event, compared with Runge-Kutta steps of 0.2 us.
TEST_P(PlantOracle, FollowsRungeKuttaThroughStartStopAndStart) {
  PlantParameters p = paper::Plant();
  p.Set(GetParam().component, GetParam().value);
  BenchProfile profile = QuietBench();
  profile.friction.stribeck_shape = GetParam().shape;
  profile.amplifier.quadrants = Quadrants::kFour;
  Plant plant(p, profile, 1);
  RungeKuttaPlant oracle(p, profile.friction);
  constexpr double kStepS = 2e-7;
  const double inputs[] = {0.02, 0.3, 3.0, 0.0, 0.1, 0.6, -0.4, -0.4};
  double speed_max = 0.0;
  double current_max = 0.0;
  for (const double uc : inputs) {
    plant.SetInput(uc);
    for (const double seconds : {kDeltaS, kPeriodS - kDeltaS}) {
      plant.Advance(seconds);
      oracle.Advance(seconds, uc, kStepS);
      speed_max = std::max(speed_max, std::abs(oracle.state()[2]));
      current_max = std::max(current_max, std::abs(oracle.state()[1]));
      // Second-order Stribeck steps of 0.1 ms against fourth-order steps of 0.2 us; the oracle
      // finds standstill at w = 0, the plant at 0.1 rad/s (one part in 3000 of the speed here).
      EXPECT_NEAR(plant.state()(2), oracle.state()[2], 2e-4 * speed_max + 0.05) << uc;
      EXPECT_NEAR(plant.state()(1), oracle.state()[1], 5e-4 * current_max) << uc;
      EXPECT_NEAR(plant.outputs().um_v, oracle.Output(uc), 2e-3) << uc;
    }
  }
  EXPECT_GT(speed_max, 0.0);
}

TEST(Plant, MotorSticksUntilTheDriveExceedsStaticFriction) {
  const BenchProfile profile = QuietBench();
  const PlantParameters p = paper::Plant();
  // i = 2.4 uc / (Ra+R1) at standstill: breaks away above Ms / KT.
  const double uc_limit =
      profile.friction.ms_nm / p.kt_nm_per_a * (p.ra_ohm + p.series_ohm) / p.gain();
  Plant plant(p, profile, 1);
  plant.SetInput(0.999 * uc_limit);
  plant.Advance(0.5);
  EXPECT_TRUE(plant.standing());
  EXPECT_EQ(plant.outputs().omega_rad_s, 0.0);
  plant.SetInput(1.001 * uc_limit);
  plant.Advance(0.05);
  EXPECT_FALSE(plant.standing());
  EXPECT_GT(plant.outputs().omega_rad_s, 0.0);
}

TEST(Plant, CoastsToStandstillInFiniteTimeAndStays) {
  const PlantParameters p = paper::Plant();
  Plant plant(p, QuietBench(), 1);
  plant.SetInput(3.0);
  plant.Advance(0.5);
  plant.SetInput(0.0);
  plant.Advance(1.0);
  EXPECT_TRUE(plant.standing());
  EXPECT_EQ(plant.outputs().omega_rad_s, 0.0);
  EXPECT_NEAR(plant.outputs().ia_a, 0.0, kExact);
}

TEST(Plant, StribeckStepsConvergeInSecondOrder) {
  // The same low-speed stretch advanced in shorter and shorter calls: the error relative to the
  // shortest decreases.
  BenchProfile profile = QuietBench();
  profile.friction.ms_nm = 0.8e-3;  // large enough to be visible
  const auto speed_after = [&profile](double call_s) {
    Plant plant(paper::Plant(), profile, 1);
    plant.SetInput(0.18);
    const int calls = static_cast<int>(std::round(0.008 / call_s));
    for (int i = 0; i < calls; ++i) {
      plant.Advance(call_s);
    }
    return plant.state()(2);
  };
  const double reference = speed_after(1e-6);
  const double coarse = std::abs(speed_after(1e-4) - reference);
  const double fine = std::abs(speed_after(2.5e-5) - reference);
  EXPECT_GT(reference, 1.0);
  EXPECT_LT(coarse, 1e-4 * reference);
  EXPECT_LT(fine, 0.25 * coarse + 1e-9);
}

TEST(Plant, SwitchedCapacitorComesUnchargedAndADriftingOneKeepsItsCharge) {
  PlantParameters p = paper::Plant();
  p.Set(paper::kC8, 10e-6);
  Plant plant(p, Frictionless(), 1);
  plant.SetInput(3.0);
  plant.Advance(1.0);
  const double charged_v = plant.state()(0);
  EXPECT_NEAR(charged_v, 7.2, 0.01);
  plant.Drift(paper::kC8, 20e-6);
  EXPECT_NEAR(plant.state()(0), 0.5 * charged_v, kExact);
  plant.Set(paper::kC8, 20e-6);  // no change: nothing is switched
  EXPECT_NEAR(plant.state()(0), 0.5 * charged_v, kExact);
  plant.Set(paper::kC8, 47e-6);
  EXPECT_EQ(plant.state()(0), 0.0);
  // At once the output falls to the divider's k R5/(R5+Re2).
  EXPECT_NEAR(plant.outputs().ua_v, 7.2 * 1.0 / 13.0, kExact);
}

TEST(Plant, OutputStopsAtTheSupplyAndComesBack) {
  BenchProfile profile = Frictionless();
  profile.amplifier.output_max_v = 6.0;
  PlantParameters p = paper::Plant();
  p.Set(paper::kC8, 1e-6);  // so that the output crosses the limit between samples
  Plant plant(p, profile, 1);
  plant.SetInput(3.0);
  for (int i = 0; i < 50; ++i) {
    plant.Advance(kPeriodS);
    EXPECT_LE(plant.outputs().ua_v, 6.0);
  }
  EXPECT_EQ(plant.outputs().ua_v, 6.0);
  plant.SetInput(2.0);
  plant.Advance(0.3);
  EXPECT_NEAR(plant.outputs().ua_v, 4.8, 1e-6);
}

TEST(Plant, TwoQuadrantsGiveNoNegativeVoltageButBrakingCurrent) {
  Plant plant(paper::Plant(), QuietBench(), 1);
  plant.SetInput(3.0);
  plant.Advance(0.5);
  plant.SetInput(-3.0);
  plant.Advance(0.002);
  EXPECT_EQ(plant.outputs().ua_v, 0.0);
  EXPECT_LT(plant.outputs().ia_a, 0.0);
  plant.Advance(1.0);
  EXPECT_TRUE(plant.standing());

  BenchProfile four = QuietBench();
  four.amplifier.quadrants = Quadrants::kFour;
  Plant reversible(paper::Plant(), four, 1);
  reversible.SetInput(-3.0);
  reversible.Advance(0.5);
  EXPECT_NEAR(reversible.outputs().ua_v, -7.2, kExact);
  EXPECT_LT(reversible.outputs().omega_rad_s, -200.0);
}

TEST(Plant, GainErrorScalesTheOutput) {
  BenchProfile profile = Frictionless();
  profile.amplifier.gain_error = 0.01;
  Plant plant(paper::Plant(), profile, 1);
  plant.SetInput(2.0);
  plant.Advance(0.5);
  EXPECT_NEAR(plant.outputs().ua_v, 4.8 * 1.01, kExact);
}

/// The paper's motor on an amplifier of 0.2 A/V.
PlantParameters PaperCurrent() {
  return hardware::LoadBench("paper-current").value()->nominal;
}

TEST(Plant, CurrentModeHoldsAFifthOfAnAmperePerVoltAndSpeedRisesLinearly) {
  BenchProfile profile = Frictionless();
  PlantParameters p = PaperCurrent();
  p.j_kg_m2 = 1.43e-4;
  Plant plant(p, profile, 1);
  plant.SetInput(0.5);
  plant.Advance(0.01);
  const double w1 = plant.outputs().omega_rad_s;
  plant.Advance(0.1);
  EXPECT_NEAR(plant.outputs().ia_a, 0.1, kExact);
  // J dw/dt = KT i - B w, B negligible here to 1e-3.
  EXPECT_NEAR(plant.outputs().omega_rad_s - w1, 0.1 * p.kt_nm_per_a * 0.1 / p.j_kg_m2, 2e-3);
}

TEST(Plant, CurrentModeRunsIntoTheSupplyWhenTheMotorIsFast) {
  BenchProfile profile = Frictionless();
  const PlantParameters p = PaperCurrent();
  Plant plant(p, profile, 1);
  plant.SetInput(0.5);
  for (int i = 0; i < 5; ++i) {
    plant.Advance(1.0);
  }
  EXPECT_EQ(plant.outputs().ua_v, 15.0);
  const double ke_kt = p.ke_v_per_rad_s * p.kt_nm_per_a;
  const double w = 15.0 * p.kt_nm_per_a / (p.b_nm_per_rad_s * p.ra_ohm + ke_kt);
  EXPECT_NEAR(plant.outputs().omega_rad_s, w, 1e-6 * w);
  EXPECT_LT(plant.outputs().ia_a, 0.1);
}

TEST(Plant, FrictionNoiseHasItsSpreadAndCorrelationTime) {
  BenchProfile profile = paper::Hardware();
  profile.friction.noise_rms_nm = 0.05e-3;
  const PlantParameters p = paper::Plant();
  Plant plant(p, profile, 3);
  plant.SetInput(3.0);
  plant.Advance(1.0);
  // At constant speed the current carries the torque: i = (Mc + n + B w)/KT (tau >> 18 ms).
  constexpr int kSamples = 200'000;
  std::vector<double> torque;
  torque.reserve(kSamples);
  double mean = 0.0;
  for (int k = 0; k < kSamples; ++k) {
    plant.Advance(kPeriodS);
    torque.push_back(p.kt_nm_per_a * plant.state()(1) - p.b_nm_per_rad_s * plant.state()(2));
    mean += torque.back() / kSamples;
  }
  double variance = 0.0;
  double lagged = 0.0;
  constexpr int kLag = 50;  // one correlation time
  for (int k = 0; k + kLag < kSamples; ++k) {
    variance += (torque[static_cast<std::size_t>(k)] - mean) *
                (torque[static_cast<std::size_t>(k)] - mean) / kSamples;
    lagged += (torque[static_cast<std::size_t>(k)] - mean) *
              (torque[static_cast<std::size_t>(k + kLag)] - mean) / kSamples;
  }
  // 4000 correlation times: 3 % on the variance; the motor's 18 ms smooth away 4 % more.
  EXPECT_NEAR(mean, profile.friction.mc_nm, 0.01 * profile.friction.mc_nm);
  EXPECT_NEAR(std::sqrt(variance), 0.05e-3, 0.06 * 0.05e-3);
  EXPECT_NEAR(lagged / variance, std::exp(-1.0), 0.06);
}

TEST(Plant, CopyGoesOnWithTheSameNumbers) {
  Plant plant(paper::Plant(), paper::Hardware(), 5);
  plant.SetInput(2.5);
  plant.Advance(0.3);
  Plant copy = plant;
  plant.Advance(0.2);
  copy.Advance(0.2);
  EXPECT_EQ(plant.state(), copy.state());
}

// For any component values within four decades either way.
TEST(Plant, StaysFiniteAndInsideTheSupplyForAnyComponentValues) {
  Random random(17);
  for (int i = 0; i < 60; ++i) {
    PlantParameters p = paper::Plant();
    for (const Component component : paper::Parts()) {
      p.Set(component, p.Get(component) * std::pow(10.0, random.Uniform(-4.0, 4.0)));
    }
    BenchProfile profile = paper::Hardware();
    profile.amplifier.quadrants = i % 2 == 0 ? Quadrants::kTwo : Quadrants::kFour;
    profile.friction.stribeck_shape = i % 3;
    Plant plant(p, profile, static_cast<std::uint64_t>(i));
    for (int k = 0; k < 20; ++k) {
      plant.SetInput(random.Uniform(-5.0, 5.0));
      plant.Advance(kDeltaS);
      const PlantOutputs out = plant.outputs();
      ASSERT_TRUE(std::isfinite(out.um_v) && std::isfinite(out.omega_rad_s) &&
                  std::isfinite(out.ia_a) && std::isfinite(out.angle_rad))
          << i;
      EXPECT_LE(std::abs(out.ua_v), 15.0);
      // Only the torque KT i drives it: the current cannot exceed what 15 V and the back EMF allow.
      EXPECT_LE(std::abs(out.omega_rad_s), 1.5 * 2.0 * 15.0 / p.ke_v_per_rad_s) << i;
      plant.Advance(kPeriodS - kDeltaS);
    }
  }
}

TEST(Plant, AdvanceAllocatesNothingThroughStartRunAndStop) {
  Plant plant(paper::Plant(), paper::Hardware(), 1);
  const faultlab::testing::HeapGuard guard;
  for (const double uc : {0.1, 3.0, 2.0, 0.0, 0.0, 2.5}) {
    plant.SetInput(uc);
    plant.Set(paper::kR1, 1.0 + uc);
    for (int k = 0; k < 30; ++k) {
      plant.Advance(kDeltaS);
      plant.Advance(kPeriodS - kDeltaS);
    }
  }
  EXPECT_EQ(guard.allocations(), 0);
}

TEST(Plant, ContractsAreHeld) {
  Plant plant(paper::Plant(), paper::Hardware(), 1);
  EXPECT_THROW(plant.SetInput(std::nan("")), ContractError);
  EXPECT_THROW(plant.Advance(-1.0), ContractError);
  EXPECT_THROW(plant.Advance(2.0), ContractError);
  EXPECT_THROW(plant.SetFriction(0.5e-3, 0.4e-3), ContractError);
  PlantParameters bad = paper::Plant();
  bad.j_kg_m2 = -1.0;
  EXPECT_THROW(Plant(bad, paper::Hardware(), 1), ContractError);
}

}  // namespace
}  // namespace faultlab::core
