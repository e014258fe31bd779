// Sensors that read otherwise than they should, on rigs whose parts are right.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "core/calibration/calibrate.h"
#include "core/diagnosis/diagnose_record.h"
#include "core/signals/prbs.h"
#include "hardware/bench/benches.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/paper_bench.h"
#include "tests/paper_rig.h"

namespace faultlab::core {
namespace {

using Change = std::function<void(Sample&)>;

std::vector<Sample> RecordWith(const Change& change, double from_s, std::uint64_t seed) {
  std::vector<Sample> record = BenchRecord({}, seed);
  for (Sample& sample : record) {
    if (sample.t_s >= from_s) change(sample);
  }
  return record;
}

struct SensorStep {
  const char* channel;
  SensorChange::Kind kind;
  double value;
  Change change;
};

using Kind = SensorChange::Kind;
const SensorStep kSteps[] = {
    {"ia", Kind::kZero, 0.03, [](Sample& s) { s.ia_a += 0.03; }},
    {"ia", Kind::kGain, 1.1, [](Sample& s) { s.ia_a *= 1.1; }},
    {"n", Kind::kZero, 15.0, [](Sample& s) { s.n_rpm += 15.0; }},
    {"n", Kind::kGain, 1.05, [](Sample& s) { s.n_rpm *= 1.05; }},
    {"n", Kind::kGain, 0.97, [](Sample& s) { s.n_rpm *= 0.97; }},
    {"n", Kind::kGain, 0.1, [](Sample& s) { s.n_rpm *= 0.1; }},
    {"um", Kind::kZero, 0.2, [](Sample& s) { s.um_v += 0.2; }},
    {"um", Kind::kGain, 0.95, [](Sample& s) { s.um_v *= 0.95; }},
};

TEST(Sensors, AChangeOfOneIsNamedAsItsOwnAndNotAsAComponent) {
  for (const SensorStep& step : kSteps) {
    const Verdict verdict =
        DiagnoseRecord(RecordWith(step.change, 10.0, 71), FreeValues(Channels::kAll)).verdict;
    SCOPED_TRACE(std::string(step.channel) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kUnknownFault);
    EXPECT_TRUE(verdict.group.empty());
    ASSERT_TRUE(verdict.sensor);
    EXPECT_EQ(verdict.sensor->channel, step.channel);
    EXPECT_EQ(verdict.sensor->kind, step.kind);
    EXPECT_NEAR(verdict.sensor->value, step.value, 4.0 * verdict.sensor->sigma);
    EXPECT_LT(verdict.sensor->sigma, 0.1 * std::abs(step.value));
    EXPECT_NE(verdict.reason.find(std::string(step.channel) + " reads "), std::string::npos);
  }
}

TEST(Sensors, OneThatDoesNotFollowTheMotorIsNamedAndNoComponent) {
  double held = 0.0;
  const SensorStep lost[] = {
      {"n", Kind::kLost, 0.0, [](Sample& s) { s.n_rpm = 0.0; }},
      {"n", Kind::kLost, 0.0, [](Sample& s) { s.n_rpm = 500.0; }},
      {"n", Kind::kLost, 0.0, [](Sample& s) { s.n_rpm = 20.0 * std::sin(1e3 * s.t_s); }},
      {"ia", Kind::kLost, 0.0, [](Sample& s) { s.ia_a = 0.0; }},
      {"um", Kind::kLost, 0.0, [](Sample& s) { s.um_v = 0.0; }},
      {"um", Kind::kLost, 0.0, [&held](Sample& s) { s.um_v = held == 0.0 ? held = s.um_v : held; }},
  };
  for (const SensorStep& step : lost) {
    const Verdict verdict =
        DiagnoseRecord(RecordWith(step.change, 10.0, 75), FreeValues(Channels::kAll)).verdict;
    SCOPED_TRACE(std::string(step.channel) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kUnknownFault);
    ASSERT_TRUE(verdict.sensor);
    EXPECT_EQ(verdict.sensor->channel, step.channel);
    EXPECT_EQ(verdict.sensor->kind, Kind::kLost);
    EXPECT_NE(verdict.reason.find(" does not follow the motor"), std::string::npos);
  }
}

TEST(Sensors, AReadingThatNeverChangesAgainIsNoPartOfTheMotorEvenWhereItIsAll) {
  const Bench& bench = *hardware::LoadBench("speed-motor").value();
  const PrbsSpec spec{.low_v = 2.0, .high_v = 4.0, .clock_s = 0.05};
  std::vector<Sample> record = SimulateRecord(bench.profiles.front(),
                                              bench.nominal,
                                              MakePrbs(spec, 2000, bench.period_s),
                                              {},
                                              10,
                                              bench.period_s);
  for (const double held_rpm : {90.5, 163.25}) {
    for (Sample& sample : record) {
      sample.ia_a = kAbsent;
      if (sample.t_s >= 12.0) sample.n_rpm = held_rpm;
    }
    const Verdict verdict = DiagnoseRecord(record, OptionsOf(bench)).verdict;
    EXPECT_EQ(verdict.kind, VerdictKind::kUnknownFault) << verdict.reason;
    ASSERT_TRUE(verdict.sensor) << verdict.reason;
    EXPECT_EQ(verdict.sensor->channel, "n");
    EXPECT_TRUE(verdict.candidates.empty());
    EXPECT_NE(verdict.reason.find("the same number since 12.00 s"), std::string::npos)
        << verdict.reason;
  }
}

/// An encoder reads exactly 0 then, and it is right.
TEST(Sensors, AMotorThatStandsStillHasNoDeadSensor) {
  for (const char* id : {"speed-motor", "gear-motor"}) {
    const Bench& bench = *hardware::LoadBench(id).value();
    const PrbsSpec spec{.low_v = 2.0, .high_v = 4.0, .clock_s = 0.05};
    std::vector<Sample> record = SimulateRecord(bench.profiles.front(),
                                                bench.nominal,
                                                MakePrbs(spec, 2000, bench.period_s),
                                                {},
                                                10,
                                                bench.period_s);
    const bool alone = bench.structure->estimated == EstimatedChannel::kSpeed;
    for (Sample& sample : record) {
      if (sample.t_s >= 12.0) sample.n_rpm = 0.0;
      if (alone) sample.ia_a = 0.0;  // a column that is not used
    }
    const Verdict verdict = DiagnoseRecord(record, OptionsOf(bench)).verdict;
    EXPECT_EQ(verdict.reason.find("the same number"), std::string::npos)
        << id << ": " << verdict.reason;
  }
}

TEST(Sensors, WithUmAloneAGainOfUmIsOneOfTheAmplifier) {
  const Verdict verdict = DiagnoseRecord(RecordWith([](Sample& s) { s.um_v *= 0.9; }, 10.0, 72),
                                         FreeValues(Channels::kUmOnly))
                              .verdict;
  EXPECT_EQ(verdict.kind, VerdictKind::kFault) << verdict.reason;
  EXPECT_FALSE(verdict.sensor);
}

TEST(Sensors, WhatIsOffAllTheTimeIsLearntAndTakenOutOfTheReadings) {
  const Change off = [](Sample& s) {
    s.um_v -= 0.03;
    s.ia_a += 5e-3;
  };
  std::vector<Sample> record = BenchRecord({AbruptFault(paper::kR12, 5.6e3)}, 73);
  for (Sample& sample : record) off(sample);
  const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(Channels::kAll));
  ASSERT_TRUE(diagnosis.calibration);
  const Calibration& learnt = *diagnosis.calibration;
  EXPECT_NEAR(learnt.ia_zero_a, 5e-3, 1e-3);
  EXPECT_NEAR(learnt.um_zero_v, -0.03, 0.015);
  EXPECT_EQ(learnt.n_zero_rpm, 0.0) << "an encoder has no such error";
  EXPECT_NEAR(learnt.nominal.b_nm_per_rad_s, paper::Plant().b_nm_per_rad_s, 0.2 * 1.8e-6);
  EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kFault) << diagnosis.verdict.reason;
  EXPECT_NEAR(ValueOf(diagnosis.verdict, paper::kR12), 5.6e3, 56.0) << diagnosis.verdict.reason;
}

TEST(Sensors, WhatIsFartherOffThanTheDescriptionAllowsIsRefusedByName) {
  std::vector<Sample> record = Between(BenchRecord({}, 74, 6.0), 0.5, 5.0);
  for (Sample& sample : record) sample.ia_a += 0.1;
  const Result<Calibration> refused = Calibrate(record, paper::ToCalibrate());
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "tolerance");
  EXPECT_NE(refused.error().message.find("the zero of a channel, ia0 = 0."), std::string::npos)
      << refused.error().message;
  EXPECT_NE(refused.error().message.find("adjust its zero"), std::string::npos);
}

// Alone, um hardly tells its zero from friction: but friction is not below 0.
TEST(ZeroOfTheVoltage, IsLearntFromItAlone) {
  std::uint64_t seed = 171;
  for (const double zero_v : {0.06, 0.1}) {
    std::vector<Sample> record = BenchRecord({AbruptFault(paper::kRa, 14.8)}, ++seed);
    for (Sample& sample : record) sample.um_v += zero_v;
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(Channels::kUmOnly));
    SCOPED_TRACE(std::to_string(zero_v) + " V: " + diagnosis.verdict.reason);
    ASSERT_TRUE(diagnosis.calibration);
    EXPECT_NEAR(diagnosis.calibration->um_zero_v, zero_v, 0.04);
    EXPECT_TRUE(Names(diagnosis.verdict, paper::kRa));
    EXPECT_NEAR(ValueOf(diagnosis.verdict, paper::kRa), 14.8, 0.05 * 14.8);
    EXPECT_GE(*diagnosis.verdict.detected_at_s, 10.0);
  }
}

}  // namespace
}  // namespace faultlab::core
