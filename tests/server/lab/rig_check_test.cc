#include "server/lab/rig_check.h"

#include <gtest/gtest.h>

#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "hardware/simulated/simulated_rig.h"

namespace faultlab::server::lab {
namespace {

constexpr double kDelta_s = 0.0095;

RigVerdict JudgeWith(core::Component component, double value, std::uint64_t seed = 5) {
  core::PlantParameters parameters;
  parameters.Set(component, value);
  const auto uc_v = core::MakePrbs({}, 300, 0.01);
  return JudgeCheck(core::SimulateRecord(core::BenchProfileBench(), parameters, uc_v, {}, seed),
                    0.01,
                    kDelta_s,
                    NominalBand(0.01, kDelta_s));
}

TEST(RigCheck, PassesANominalRecord) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    const RigVerdict verdict = JudgeWith(core::Component::kR1, 1.0, seed);
    EXPECT_TRUE(verdict.passed) << verdict.text;
  }
}

TEST(RigCheck, FailsEveryRelayThatSticksInAFault) {
  for (const auto component : core::kAllComponents) {
    if (!core::IsRelaySwitched(component)) continue;
    for (int position = 1; position < core::kRelayPositions; ++position) {
      const double value = core::RelayValues(component)[static_cast<std::size_t>(position)];
      const RigVerdict verdict = JudgeWith(component, value);
      EXPECT_FALSE(verdict.passed) << Name(component) << " = " << value;
    }
  }
}

TEST(RigCheck, JudgesByTheRigsOwnBandOnceItHasOne) {
  const RigBand nominal = NominalBand(0.01, kDelta_s);
  const RigVerdict healthy = JudgeWith(core::Component::kR1, 1.0);
  ASSERT_TRUE(healthy.measured.has_value());
  // A bench whose amplifier is 15 % above the data sheet: refused by it, at home in its own band.
  RigBand strong = *healthy.measured;
  strong.b0d *= 1.15;
  strong.gain *= 1.15;
  EXPECT_TRUE(CheckBand(strong, nominal).ok());
  core::PlantParameters parameters;
  const auto uc_v = core::MakePrbs({}, 300, 0.01);
  auto record = core::SimulateRecord(core::BenchProfileBench(), parameters, uc_v, {}, 5);
  for (core::Sample& sample : record) sample.um_v *= 1.15;
  EXPECT_FALSE(JudgeCheck(record, 0.01, kDelta_s, nominal).passed);
  EXPECT_TRUE(JudgeCheck(record, 0.01, kDelta_s, strong).passed);
  EXPECT_FALSE(JudgeCheck(core::SimulateRecord(core::BenchProfileBench(), parameters, uc_v, {}, 5),
                          0.01,
                          kDelta_s,
                          strong)
                   .passed)
      << "and the data sheet's bench is not its own";
}

TEST(RigCheck, ARelayThatSticksInAFaultNeverBecomesTheNormOfItsRig) {
  const RigBand nominal = NominalBand(0.01, kDelta_s);
  for (const auto component : core::kAllComponents) {
    if (!core::IsRelaySwitched(component)) continue;
    for (int position = 1; position < core::kRelayPositions; ++position) {
      const double value = core::RelayValues(component)[static_cast<std::size_t>(position)];
      const RigVerdict verdict = JudgeWith(component, value);
      EXPECT_FALSE(verdict.measured && CheckBand(*verdict.measured, nominal).ok())
          << Name(component) << " = " << value << ": " << verdict.text;
    }
  }
}

TEST(RigCheck, FailsARecordThatSaysNothing) {
  EXPECT_FALSE(JudgeCheck({}, 0.01, kDelta_s, NominalBand(0.01, kDelta_s)).passed);
  std::vector<core::Sample> still(300);
  for (std::size_t i = 0; i < still.size(); ++i) {
    still[i] = {static_cast<std::int64_t>(i), 0.01 * static_cast<double>(i), 2.0, 4.8};
  }
  EXPECT_FALSE(JudgeCheck(still, 0.01, kDelta_s, NominalBand(0.01, kDelta_s)).passed);
}

TEST(RigCheck, PassesAHealthySimulatedRigAndLeavesItIdle) {
  hardware::SimulatedRigOptions options;
  options.speed = 50.0;
  const auto rig = hardware::MakeSimulatedRig(options);
  const RigVerdict verdict = CheckRig(*rig, hardware::Epoch{1});
  EXPECT_TRUE(verdict.passed) << verdict.text;
  EXPECT_EQ(rig->state(), hardware::RigState::kIdle);
}

}  // namespace
}  // namespace faultlab::server::lab
