#include "server/lab/rig_check.h"

#include <gtest/gtest.h>

#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "core/signals/prbs.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/paper_bench.h"
#include "tests/server/run/fake_rig.h"

namespace faultlab::server::lab {
namespace {

constexpr double kDelta_s = 0.0095;

const RigNorm& Nominal() {
  static const RigNorm norm = NominalNorm(paper::Bench(), kDelta_s).value();
  return norm;
}

RigVerdict JudgeWith(core::Component component, double value, std::uint64_t seed = 5) {
  core::PlantParameters parameters = paper::Plant();
  parameters.Set(component, value);
  const auto uc_v = core::MakePrbs({}, 300, 0.01);
  return JudgeCheck(
      core::SimulateRecord(paper::Hardware(), parameters, uc_v, {}, seed, paper::kPeriodS),
      paper::Bench(),
      kDelta_s,
      Nominal());
}

TEST(RigCheck, PassesANominalRecord) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    const RigVerdict verdict = JudgeWith(paper::kR1, 1.0, seed);
    EXPECT_TRUE(verdict.passed) << verdict.text;
  }
}

TEST(RigCheck, FailsEveryRelayThatSticksInAFault) {
  for (const auto component : paper::Parts()) {
    if (!core::IsSwitched(component)) continue;
    for (const core::SwitchPosition& position : component.info().positions) {
      const double value = position.value;
      if (value == component.info().nominal) continue;
      const RigVerdict verdict = JudgeWith(component, value);
      EXPECT_FALSE(verdict.passed) << Name(component) << " = " << value;
    }
  }
}

TEST(RigCheck, IsPutOffWhenTheRigHeardNothingFromUsInTime) {
  // What PlayRun says of a run that the rig's watchdog ended.
  const RigVerdict stalled = VerdictOf({core::ErrorCode::kBusy, "the rig stopped: watchdog", ""});
  EXPECT_TRUE(stalled.put_off);
  EXPECT_FALSE(stalled.passed);
  EXPECT_FALSE(VerdictOf({core::ErrorCode::kUnavailable, "an interlock tripped", ""}).put_off);
}

TEST(RigCheck, JudgesByTheRigsOwnBandOnceItHasOne) {
  const RigVerdict healthy = JudgeWith(paper::kR1, 1.0);
  ASSERT_TRUE(healthy.measured.has_value());
  // A bench whose amplifier is 15 % above the data sheet: outside that band, but inside its own.
  RigBand strong = *healthy.measured;
  strong.b0d *= 1.15;
  strong.gain *= 1.15;
  EXPECT_TRUE(CheckBand(strong, Nominal()).ok());
  core::PlantParameters parameters = paper::Plant();
  const auto uc_v = core::MakePrbs({}, 300, 0.01);
  auto record = core::SimulateRecord(paper::Hardware(), parameters, uc_v, {}, 5, paper::kPeriodS);
  for (core::Sample& sample : record) sample.um_v *= 1.15;
  EXPECT_FALSE(JudgeCheck(record, paper::Bench(), kDelta_s, Nominal()).passed);
  EXPECT_TRUE(JudgeCheck(record, paper::Bench(), kDelta_s, Nominal(), strong).passed);
  EXPECT_FALSE(
      JudgeCheck(core::SimulateRecord(paper::Hardware(), parameters, uc_v, {}, 5, paper::kPeriodS),
                 paper::Bench(),
                 kDelta_s,
                 Nominal(),
                 strong)
          .passed)
      << "and the data sheet's bench is not its own";
}

TEST(RigCheck, ARelayThatSticksInAFaultNeverBecomesTheNormOfItsRig) {
  for (const auto component : paper::Parts()) {
    if (!core::IsSwitched(component)) continue;
    for (const core::SwitchPosition& position : component.info().positions) {
      const double value = position.value;
      if (value == component.info().nominal) continue;
      const RigVerdict verdict = JudgeWith(component, value);
      EXPECT_FALSE(verdict.measured && CheckBand(*verdict.measured, Nominal()).ok())
          << Name(component) << " = " << value << ": " << verdict.text;
    }
  }
}

TEST(RigCheck, FailsARecordThatSaysNothing) {
  EXPECT_FALSE(JudgeCheck({}, paper::Bench(), kDelta_s, Nominal()).passed);
  std::vector<core::Sample> still(300);
  for (std::size_t i = 0; i < still.size(); ++i) {
    still[i] = {static_cast<std::int64_t>(i), 0.01 * static_cast<double>(i), 2.0, 4.8};
  }
  EXPECT_FALSE(JudgeCheck(still, paper::Bench(), kDelta_s, Nominal()).passed);
}

/// A rig whose lease or relays answer as a test requires.
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

/// The shipped benches whose current is mostly friction: other values of it, within the norm, are
/// no fault; the parts of the output circuit are.
class RigCheckOfDrivers : public testing::TestWithParam<const char*> {
 protected:
  const core::Bench& bench_ = *hardware::LoadBench(GetParam()).value();
  RigNorm norm_ = NominalNorm(bench_, bench_.delta_s).value();

  RigVerdict Judge(const core::PlantParameters& rig, double friction_sd, std::uint64_t seed) {
    core::BenchProfile profile = bench_.profiles.front();
    profile.friction.mc_nm = bench_.norm.mc_nm + friction_sd * bench_.norm.mc_sigma_nm;
    profile.friction.ms_nm = profile.friction.mc_nm * 1.1;
    const auto uc_v =
        core::Generate(bench_.excitation, CheckSeconds(bench_), bench_.period_s).value();
    return JudgeCheck(core::SimulateRecord(profile, rig, uc_v, {}, seed, bench_.period_s),
                      bench_,
                      bench_.delta_s,
                      norm_);
  }
};

TEST_P(RigCheckOfDrivers, PassHealthyRigsOfAnyFriction) {
  for (const double friction_sd : {-1.5, -0.5, 0.5, 1.5}) {
    for (const std::uint64_t seed : {21u, 22u, 23u, 24u}) {
      const RigVerdict verdict = Judge(bench_.nominal, friction_sd, seed);
      EXPECT_TRUE(verdict.passed) << friction_sd << ": " << verdict.text;
      ASSERT_TRUE(verdict.measured.has_value());
      EXPECT_TRUE(CheckBand(*verdict.measured, norm_).ok());
    }
  }
}

TEST_P(RigCheckOfDrivers, FailAWrongResistanceOrGain) {
  for (const char* symbol : {"Ra", "k"}) {
    for (const double factor : {0.5, 2.0}) {
      core::PlantParameters rig = bench_.nominal;
      const int parameter = rig.structure->Find(symbol);
      rig.Set(parameter, factor * rig.Get(parameter));
      const RigVerdict verdict = Judge(rig, 0.0, 31);
      EXPECT_FALSE(verdict.passed) << symbol << " x " << factor;
      ASSERT_TRUE(verdict.measured.has_value());
      EXPECT_FALSE(CheckBand(*verdict.measured, norm_).ok()) << symbol << " x " << factor;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, RigCheckOfDrivers, testing::Values("servo-motor", "gear-motor"));

}  // namespace
}  // namespace faultlab::server::lab
