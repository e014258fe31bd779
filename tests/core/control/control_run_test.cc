// Speed control in closed loop with the shipping pipeline, on the shipping plant.
#include "core/control/closed_loop/control_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/isolability/isolability.h"
#include "core/signals/random.h"
#include "hardware/bench/benches.h"
#include "hardware/rig_limits.h"
#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

constexpr int kWrongDiagnoses = 60;

ControlRecord Drive(const std::vector<Fault>& faults,
                    ControlKind kind,
                    std::uint64_t seed = 1,
                    double duration_s = 24.0,
                    const Bench& bench = paper::Bench()) {
  ControlPlan plan;
  plan.bench = &bench;
  plan.faults = faults;
  plan.options.kind = kind;
  plan.seed = seed;
  plan.duration_s = duration_s;
  auto record = RunControl(plan);
  EXPECT_TRUE(record.ok()) << (record.ok() ? "" : record.error().message);
  return record.ok() ? std::move(record).value() : ControlRecord{};
}

Fault At10(const char* symbol, double value) {
  return {paper::Bench().Find(symbol).value(), value, 10.0};
}

TEST(ControlRun, KeepsTheSpeedOfAHealthyRig) {
  const ControlRecord record = Drive({}, ControlKind::kCompensated);
  EXPECT_LT(record.quality.steady_error_rad_s, 0.5);
  EXPECT_LT(record.quality.overshoot_percent, 15.0);
  ASSERT_TRUE(record.quality.settling_s);
  EXPECT_LT(*record.quality.settling_s, 0.5);
  EXPECT_FALSE(record.compensated_at_s);
  EXPECT_TRUE(record.accommodated);
}

TEST(ControlRun, ACompensatedFaultIsHardlySeen) {
  const double healthy = Drive({}, ControlKind::kCompensated).quality.iae_rad;
  for (const auto& fault : {At10("R1", 56.0), At10("R12", 5600.0), At10("Ra", 74.1)}) {
    const ControlRecord nominal = Drive({fault}, ControlKind::kNominal);
    const ControlRecord compensated = Drive({fault}, ControlKind::kCompensated);
    const std::string name(Name(fault.component));
    ASSERT_TRUE(compensated.compensated_at_s) << name;
    EXPECT_LT(compensated.quality.iae_rad, nominal.quality.iae_rad) << name;
    EXPECT_TRUE(compensated.accommodated) << name;
    EXPECT_GT(healthy, 0.0);
  }
}

TEST(ControlRun, TwoHoldsAfterAFaultTheRigIsAsGoodAsNew) {
  const double healthy = Drive({}, ControlKind::kCompensated).quality.late_iae_rad;
  int accommodated = 0;
  for (const FaultSize& fault : FaultsOf(paper::Bench())) {
    const std::string name = std::string(Name(fault.component)) + " " + std::to_string(fault.value);
    const ControlRecord record =
        Drive({{fault.component, fault.value, 10.0}}, ControlKind::kCompensated);
    ASSERT_TRUE(record.compensated_at_s) << name;
    if (!record.accommodated) continue;
    ++accommodated;
    // A hundred times the inertia takes the drive to its end at every step.
    const bool hard = fault.value == 143e-6;
    EXPECT_LE(record.quality.late_iae_rad, (hard ? 3.5 : 1.2) * healthy) << name;
    EXPECT_LT(record.quality.overshoot_percent, 15.0) << name;
  }
  EXPECT_EQ(accommodated, 16) << "all but R12 = 2 kohm and B x 100";
}

TEST(ControlRun, AFaultThatCannotBeAccommodatedIsRefusedWithTheSpeedThatCan) {
  const ControlRecord record = Drive({At10("R12", 2000.0)}, ControlKind::kCompensated);
  EXPECT_FALSE(record.accommodated);
  EXPECT_NEAR(record.reachable_rad_s, 149.0, 6.0);
}

TEST(ControlRun, NothingLeavesTheEnvelope) {
  const Bench& bench = paper::Bench();
  Random random(5);
  const std::vector<Component> parts = bench.components();
  std::vector<Fault> faults = {At10("B", 180e-6), At10("J", 143e-6), At10("Ra", 0.741)};
  for (int i = 0; i < 12; ++i) {
    const auto which =
        static_cast<std::size_t>(random.Uniform(0.0, 0.999) * static_cast<double>(parts.size()));
    const Component component = parts[which];
    const double value = bench.nominal.Get(component) * std::exp(random.Uniform(-2.5, 2.5));
    faults.push_back({component, value, random.Uniform(7.0, 12.0)});
  }
  for (std::size_t i = 0; i < faults.size(); ++i) {
    const std::string name =
        std::string(Name(faults[i].component)) + " " + std::to_string(faults[i].value);
    const ControlRecord record = Drive({faults[i]}, ControlKind::kCompensated, 100U + i, 30.0);
    hardware::Interlocks interlocks(bench.limits);
    for (const Sample& sample : record.samples) {
      const auto trip = interlocks.Check(sample, bench.period_s);
      ASSERT_FALSE(trip) << name << ", " << sample.t_s << " s: " << trip->text;
    }
    double before = record.samples.front().uc_v;
    for (const Sample& sample : record.samples) {
      EXPECT_GE(sample.uc_v, bench.limits.uc_v_min - 1e-3);
      EXPECT_LE(sample.uc_v, bench.limits.uc_v_max + 1e-3);
      if (sample.t_s > record.control_from_s) {
        EXPECT_LE(std::abs(sample.uc_v - before),
                  bench.limits.slew_v_per_s * bench.period_s + 1e-3);
      }
      before = sample.uc_v;
    }
    for (const double speed : record.speed_rad_s) ASSERT_TRUE(std::isfinite(speed));
  }
}

TEST(ControlRun, ASpeedThatOverheatsTheMotorIsNotFollowed) {
  const ControlRecord record = Drive({At10("B", 180e-6)}, ControlKind::kCompensated);
  EXPECT_FALSE(record.accommodated);
  const PlantParameters& motor = paper::Bench().nominal;
  const double torque_nm = paper::Bench().limits.current_continuous_a * motor.kt_nm_per_a - 0.33e-3;
  EXPECT_NEAR(record.reachable_rad_s, torque_nm / 180e-6, 0.1 * torque_nm / 180e-6);
}

/// Told of another part than the one that failed, the control does not believe it, by what was read
/// since the alarm, or gives it up: 1.5 times the error of one that is told nothing in 54 of
/// 60, 2.3 times at worst, in what passes until then. (Without: 58.)
TEST(ControlRun, AWrongDiagnosisIsGivenUp) {
  const std::vector<FaultSize> all = FaultsOf(paper::Bench());
  Random random(11);
  const auto any = [&] {
    return all[static_cast<std::size_t>(random.Uniform(0.0, 0.999) *
                                        static_cast<double>(all.size()))];
  };
  int given_up = 0;
  int worse = 0;
  for (int i = 0; i < kWrongDiagnoses; ++i) {
    const FaultSize truth = any();
    FaultSize told = any();
    while (told.component == truth.component) told = any();
    ControlPlan plan;
    plan.bench = &paper::Bench();
    plan.faults = {{truth.component, truth.value, 10.0}};
    plan.duration_s = 24.0;
    plan.options.kind = ControlKind::kNominal;
    const double without = RunControl(plan).value().quality.iae_rad;
    plan.options.kind = ControlKind::kCompensated;
    plan.told = Fault{told.component, told.value, 10.25};
    const ControlRecord record = RunControl(plan).value();
    const std::string name = std::string(Name(truth.component)) + " " +
                             std::to_string(truth.value) + ", told " +
                             std::string(Name(told.component)) + " " + std::to_string(told.value);
    EXPECT_LE(record.quality.iae_rad, 2.4 * without) << name;
    if (record.quality.iae_rad > 1.5 * without) ++worse;
    if (record.gave_up_at_s) ++given_up;
  }
  EXPECT_LE(worse, 6) << "of those of more than 1.5 times";
  EXPECT_GT(given_up, 0) << "the trial does not find all";
}

TEST(ControlRun, ARightDiagnosisIsKept) {
  for (const FaultSize& fault : FaultsOf(paper::Bench())) {
    const ControlRecord record =
        Drive({{fault.component, fault.value, 10.0}}, ControlKind::kCompensated);
    EXPECT_FALSE(record.gave_up_at_s) << Name(fault.component) << " " << fault.value;
  }
}

/// In current mode the range of the input is eleven times what the motor's friction asks for: the
/// loop is as fast as that lets it be, and slow changes of friction are no wrong diagnosis.
TEST(ControlRun, OfAMotorDrivenByACurrentKeepsItsSpeedAndTheRightDiagnoses) {
  const Bench& bench = *hardware::LoadBench("paper-current").value();
  const ControlRecord healthy = Drive({}, ControlKind::kCompensated, 1, 24.0, bench);
  ASSERT_TRUE(healthy.quality.settling_s);
  EXPECT_LT(*healthy.quality.settling_s, 0.6);
  EXPECT_LT(healthy.reachable_rad_s, 15.5 / bench.nominal.ke_v_per_rad_s) << "the supply ends it";
  for (const FaultSize& fault : FaultsOf(bench)) {
    const ControlRecord record =
        Drive({{fault.component, fault.value, 10.0}}, ControlKind::kCompensated, 1, 24.0, bench);
    const std::string name =
        std::string(Name(fault.component)) + " = " + std::to_string(fault.value);
    ASSERT_EQ(record.verdict.kind, VerdictKind::kFault) << name << ": " << record.verdict.reason;
    EXPECT_EQ(record.verdict.group.front(), fault.component) << name;
    EXPECT_FALSE(record.gave_up_at_s) << name;
  }
}

TEST(ControlRun, RefusesWhatNoRigCanDo) {
  ControlPlan plan;
  plan.bench = &paper::Bench();
  plan.reference.high_rad_s = 2000.0;
  const auto too_fast = RunControl(plan);
  ASSERT_FALSE(too_fast.ok());
  EXPECT_EQ(too_fast.error().field, "reference");
  plan.reference.high_rad_s = 170.0;
  plan.duration_s = 3.0;
  EXPECT_EQ(RunControl(plan).error().field, "duration_s");
  plan.duration_s = 1e12;
  EXPECT_EQ(RunControl(plan).error().field, "duration_s");
  plan.duration_s = 20.0;
  for (const double hold_s : {0.0, 0.001, -1.0, 1e12, std::nan("")}) {
    plan.reference.hold_s = hold_s;
    EXPECT_EQ(RunControl(plan).error().field, "hold_s") << hold_s;
  }
  plan.reference.hold_s = 0.08;
  EXPECT_TRUE(RunControl(plan).ok());
}

}  // namespace
}  // namespace faultlab::core
