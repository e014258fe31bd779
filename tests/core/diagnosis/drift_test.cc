// A fault that creeps, on benches other than the paper's.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "core/diagnosis/pipeline.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "hardware/bench/benches.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

std::vector<Sample> Creeping(const Bench& bench,
                             const ExcitationSpec& input,
                             unsigned seed,
                             const char* symbol,
                             double value,
                             double from_s,
                             double to_s,
                             double duration_s = 20.0) {
  Fault fault = AbruptFault(bench.Find(symbol).value(), value, from_s);
  fault.kind = FaultKind::kDrift;
  fault.until_s = to_s;
  return SimulateRecord(bench.profiles.front(),
                        bench.nominal,
                        Generate(input, duration_s, bench.period_s).value(),
                        std::vector<Fault>{fault},
                        seed,
                        bench.period_s);
}

TEST(Creeping, ThatHasJustEndedIsNamed) {
  const Bench& servo = *hardware::LoadBench("servo-motor").value();
  for (const unsigned seed : tests::Seeds(1, 9)) {
    const PrbsSpec input{.low_v = 1.8, .high_v = 2.7, .clock_s = 0.008, .seed = seed};
    const Verdict verdict =
        DiagnoseRecord(Creeping(servo, input, seed, "k", 2.0, 13.5, 19.2), OptionsOf(servo))
            .verdict;
    EXPECT_EQ(verdict.kind, VerdictKind::kFault) << seed << ": " << verdict.reason;
    EXPECT_TRUE(Names(verdict, servo.Find("k").value())) << seed << ": " << verdict.reason;
  }
}

// By the speed alone B is learnt within a half: as far as that a rig may be healthy, but not when
// it has been found to have changed.
TEST(Creeping, OfAFaultThatIsKnownIsNoWarming) {
  const Bench& speed = *hardware::LoadBench("speed-motor").value();
  for (const unsigned seed : tests::Seeds(1, 17)) {
    const PrbsSpec input{.low_v = 2.0, .high_v = 3.9, .clock_s = 0.06, .seed = seed};
    const Verdict verdict =
        DiagnoseRecord(Creeping(speed, input, seed, "B", 3e-6, 11.26, 14.3), OptionsOf(speed))
            .verdict;
    EXPECT_EQ(verdict.kind, VerdictKind::kFault) << seed << ": " << verdict.reason;
    EXPECT_TRUE(Names(verdict, speed.Find("B").value())) << seed << ": " << verdict.reason;
  }
}

ExcitationSpec Sines(const Bench& bench, unsigned seed) {
  MultisineSpec sines;
  sines.offset_v = 0.4 * bench.limits.uc_v_max;
  sines.amplitude_v = 0.16 * bench.limits.uc_v_max;
  sines.lines = 20;
  sines.seed = seed;
  return sines;
}

ExcitationSpec Prbs(const Bench& bench, unsigned seed) {
  const double full_v = bench.limits.uc_v_max;
  return PrbsSpec{.low_v = 0.24 * full_v, .high_v = 0.56 * full_v, .clock_s = 0.05, .seed = seed};
}

/// @param share  of the part's healthy value that is left; it goes there from 12 s to to_s
void ExpectNamed(const Bench& bench,
                 const ExcitationSpec& input,
                 unsigned seed,
                 const char* symbol,
                 double share,
                 double to_s,
                 double count_rpm) {
  SCOPED_TRACE(bench.name + ' ' + symbol + ", seed " + std::to_string(seed));
  const Component part = bench.Find(symbol).value();
  std::vector<Sample> record =
      Creeping(bench, input, seed, symbol, share * bench.nominal.Get(part), 12.0, to_s);
  for (Sample& each : record) each.n_rpm = count_rpm * std::round(each.n_rpm / count_rpm);
  const Verdict verdict = DiagnoseRecord(record, OptionsOf(bench)).verdict;
  EXPECT_EQ(verdict.kind, VerdictKind::kFault) << verdict.reason;
  EXPECT_TRUE(Names(verdict, part)) << verdict.reason;
}

// A motor at rest shows little: friction there hides what it was. What was seen on the way counts.
void ExpectNamedAtRest(const char* name, const char* symbol, double share, double count_rpm) {
  const Bench& bench = *hardware::LoadBench(name).value();
  for (const unsigned seed : tests::Seeds(1, 9)) {
    const double to_s = seed % 2 == 0 ? 12.01 : 14.0 + 0.3 * seed;
    const ExcitationSpec input = seed % 4 < 2 ? Sines(bench, seed) : Prbs(bench, seed);
    ExpectNamed(bench, input, seed, symbol, share, to_s, count_rpm);
  }
}

TEST(Creeping, UntilTheMotorRestsIsNamed) {
  ExpectNamedAtRest("speed-motor", "Ra", 10.0, 0.6);
  ExpectNamedAtRest("speed-motor", "Ra", 10.0, 1.8);
  ExpectNamedAtRest("speed-motor", "k", 0.1, 0.6);
  ExpectNamedAtRest("gear-motor", "k", 0.1, 1.8);
}

// Its beginning looks like another part that has failed at once, and is over before it can be
// followed: at rest it stays one of those that nothing told apart.
TEST(Creeping, TooFastToBeFollowedIsNotTakenForAnother) {
  const Bench& speed = *hardware::LoadBench("speed-motor").value();
  for (unsigned seed : {4U, 13U}) {
    const double to_s = 12.6 + 0.006 * seed;
    ExpectNamed(speed, Prbs(speed, seed), seed, "k", 0.1, to_s, 0.001);
    ExpectNamed(speed, Sines(speed, seed), seed, "k", 0.1, to_s, 0.001);
  }
}

// By the speed alone half as much B again may be a healthy rig, but the detector sees it change.
TEST(Creeping, ThatComesToNothingIsToldOnce) {
  const Bench& speed = *hardware::LoadBench("speed-motor").value();
  const PrbsSpec input{.low_v = 0.9, .high_v = 3.3, .clock_s = 0.05, .seed = 4};
  const double more = 1.6 * speed.nominal.Get(speed.Find("B").value());
  Pipeline pipeline(OptionsOf(speed));
  int told = 0;
  bool open = false;
  int tasks = 0;
  for (const Sample& sample : Creeping(speed, input, 4, "B", more, 10.0, 30.0, 50.0)) {
    pipeline.Push(sample);
    for (; auto task = pipeline.TakeTask(); ++tasks) pipeline.Accept(RunTask(*task));
    const bool now = pipeline.verdict().kind == VerdictKind::kFault;
    told += now && !open ? 1 : 0;
    open = now;
  }
  EXPECT_GT(tasks, 20) << "it raises alarms";
  EXPECT_EQ(told, 1);
}

}  // namespace
}  // namespace faultlab::core
