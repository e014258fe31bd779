#include "server/lab/rig_check.h"

#include <gtest/gtest.h>

#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/server/run/fake_rig.h"

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

/// A rig whose lease or relays answer as a test wants it.
class RefusingRig : public tests::FakeRig {
 public:
  core::Result<hardware::SelfTestReport> SelfTest(hardware::Epoch) override { return answer_; }
  core::Result<hardware::SelfTestReport> answer_ = hardware::SelfTestReport{};
};

RigVerdict VerdictWhenRefused(core::ErrorCode code, std::string_view field) {
  RefusingRig rig;
  rig.answer_ = core::Error{code, "why it was refused", std::string(field)};
  return CheckRig(rig, hardware::Epoch{1});
}

TEST(RigCheck, SaysWhatTheRigSaidAndNotThatItsRelaysDoNotAnswer) {
  using core::ErrorCode;
  const RigVerdict busy = VerdictWhenRefused(ErrorCode::kBusy, hardware::kLeaseField);
  EXPECT_TRUE(busy.put_off) << "another lab holds it";
  EXPECT_EQ(busy.text, "why it was refused");
  EXPECT_TRUE(VerdictWhenRefused(ErrorCode::kUnavailable, hardware::kLeaseField).put_off);
  const RigVerdict behind = VerdictWhenRefused(ErrorCode::kStale, hardware::kLeaseField);
  EXPECT_FALSE(behind.put_off) << "waiting does not help";
  EXPECT_FALSE(behind.passed);
  EXPECT_EQ(behind.text,
            "why it was refused: this server's database is behind the rig, adopt the rig");
  for (const ErrorCode code : {ErrorCode::kStale, ErrorCode::kBusy, ErrorCode::kUnavailable}) {
    const RigVerdict other = VerdictWhenRefused(code, "epoch");
    EXPECT_FALSE(other.put_off);
    EXPECT_FALSE(other.passed);
    EXPECT_EQ(other.text, "why it was refused");
  }
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
