// A fault that creeps, on benches other than the paper's.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "core/diagnosis/pipeline.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "hardware/bench/benches.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/verdicts.h"

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
  for (unsigned seed = 1; seed < 9; ++seed) {
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
  for (unsigned seed = 1; seed < 17; ++seed) {
    const PrbsSpec input{.low_v = 2.0, .high_v = 3.9, .clock_s = 0.06, .seed = seed};
    const Verdict verdict =
        DiagnoseRecord(Creeping(speed, input, seed, "B", 3e-6, 11.26, 14.3), OptionsOf(speed))
            .verdict;
    EXPECT_EQ(verdict.kind, VerdictKind::kFault) << seed << ": " << verdict.reason;
    EXPECT_TRUE(Names(verdict, speed.Find("B").value())) << seed << ": " << verdict.reason;
  }
}

// By the speed alone a motor at rest shows little: of what has brought it there nothing is left out
// that friction may hide.
TEST(Creeping, ThatBringsAMotorToRestIsNamed) {
  const Bench& speed = *hardware::LoadBench("speed-motor").value();
  const Component winding = speed.Find("Ra").value();
  for (unsigned seed = 1; seed < 13; ++seed) {
    const PrbsSpec prbs{.low_v = 1.2, .high_v = 2.8, .clock_s = 0.05, .seed = seed};
    MultisineSpec sines;
    sines.offset_v = 2.0;
    sines.amplitude_v = 0.8;
    sines.lines = 20;
    sines.seed = seed;
    for (const ExcitationSpec& input : {ExcitationSpec(prbs), ExcitationSpec(sines)}) {
      std::vector<Sample> record =
          Creeping(speed, input, seed, "Ra", 60.0, 12.0, 14.0 + 0.2 * seed);
      for (Sample& each : record) each.n_rpm = 1.8 * std::round(each.n_rpm / 1.8);  // an encoder
      const Verdict verdict = DiagnoseRecord(record, OptionsOf(speed)).verdict;
      EXPECT_EQ(verdict.kind, VerdictKind::kFault) << seed << ": " << verdict.reason;
      EXPECT_TRUE(Names(verdict, winding)) << Name(input) << seed << ": " << verdict.reason;
    }
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
