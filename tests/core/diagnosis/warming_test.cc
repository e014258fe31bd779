// A winding whose resistance rises while the motor works, and faults that begin meanwhile.
#include <gtest/gtest.h>

#include <string>

#include "core/diagnosis/diagnose_record.h"
#include "core/diagnosis/pipeline.h"
#include "hardware/bench/benches.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/real_motors.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/paper_bench.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

Fault Ramp(double ra_factor, double from_s, double to_s) {
  Fault fault = AbruptFault(paper::kRa, ra_factor * paper::Plant().ra_ohm, from_s);
  fault.kind = FaultKind::kDrift;
  fault.until_s = to_s;
  return fault;
}

Verdict VerdictOf(const std::vector<Fault>& faults, std::uint64_t seed) {
  return DiagnoseRecord(BenchRecord(faults, seed), FreeValues(Channels::kAll)).verdict;
}

TEST(Warming, IsNoFault) {
  for (const std::uint64_t seed : tests::Seeds(121, 126)) {
    const Verdict verdict = VerdictOf({Ramp(1.02, 0.0, 20.0)}, seed);
    EXPECT_EQ(verdict.kind, VerdictKind::kNominal) << verdict.reason;
    EXPECT_FALSE(verdict.detected_at_s);
  }
}

TEST(Warming, IsSaidWhenItHasBeenSeen) {
  const Verdict verdict = VerdictOf({Ramp(1.03, 5.0, 20.0)}, 131);
  EXPECT_EQ(verdict.kind, VerdictKind::kNominal);
  EXPECT_EQ(verdict.reason.find("the winding has moved by +"), 0U) << verdict.reason;
}

TEST(Warming, IsAtNoTimeSaidToBeAPart) {
  for (const std::uint64_t seed : tests::Seeds(161, 167)) {
    Pipeline pipeline(FreeValues(Channels::kAll));
    bool alarm = false;
    for (const Sample& sample : BenchRecord({Ramp(1.02, 0.0, 20.0)}, seed)) {
      pipeline.Push(sample);
      while (auto task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
      const Verdict& verdict = pipeline.verdict();
      alarm |= verdict.kind == VerdictKind::kFault;
      EXPECT_TRUE(verdict.group.empty()) << seed << ": " << verdict.reason;
      if (!verdict.group.empty()) break;
    }
    EXPECT_TRUE(alarm) << "else nothing was tried";
  }
}

TEST(Warming, DelaysNoFaultThatBeginsWhileItsAlarmIsWorkedOut) {
  for (const std::uint64_t seed : tests::Seeds(181, 184)) {
    Pipeline warm(FreeValues(Channels::kAll));
    double at_s = 0.0;
    for (const Sample& sample : BenchRecord({Ramp(1.02, 0.0, 20.0)}, seed)) {
      warm.Push(sample);
      while (auto task = warm.TakeTask()) warm.Accept(RunTask(*task));
      if (warm.verdict().kind != VerdictKind::kFault) continue;
      at_s = sample.t_s + 0.3;
      break;
    }
    ASSERT_GT(at_s, 0.3) << "else nothing was tried";
    Pipeline pipeline(FreeValues(Channels::kAll));
    const Fault fault = AbruptFault(paper::kR12, 5.6e3, at_s);
    for (const Sample& sample : BenchRecord({Ramp(1.02, 0.0, 20.0), fault}, seed)) {
      if (sample.t_s > at_s + 1.05) break;
      pipeline.Push(sample);
      while (auto task = pipeline.TakeTask()) pipeline.Accept(RunTask(*task));
    }
    const Verdict& verdict = pipeline.verdict();
    EXPECT_EQ(verdict.kind, VerdictKind::kFault) << seed << ": " << verdict.reason;
    EXPECT_TRUE(Names(verdict, paper::kR12)) << seed << ": " << verdict.reason;
    EXPECT_NEAR(*verdict.detected_at_s, at_s, 0.015) << seed;
    EXPECT_EQ(pipeline.Snapshot().episodes.size(), 1U) << "what it took the place of was no fault";
  }
}

TEST(Warming, HidesNoFaultThatBeginsMeanwhile) {
  const std::pair<Component, double> faults[] = {
      {paper::kR12, 5.6e3}, {paper::kR1, 56.0}, {paper::kJ, 2e-6}};
  std::uint64_t seed = 141;
  for (const auto& [component, value] : faults) {
    const Verdict verdict =
        VerdictOf({Ramp(1.02, 0.0, 20.0), AbruptFault(component, value)}, ++seed);
    SCOPED_TRACE(std::string(Name(component)) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kFault);
    EXPECT_TRUE(Names(verdict, component));
    EXPECT_NEAR(ValueOf(verdict, component), value, 0.03 * value);
  }
}

TEST(Warming, IsNotWhatComesAtOnceOrTooFast) {
  const double ra = paper::Plant().ra_ohm;
  for (const Fault& fault : {AbruptFault(paper::kRa, 1.05 * ra), Ramp(1.5, 10.0, 20.0)}) {
    const Verdict verdict = VerdictOf({fault}, 151);
    EXPECT_EQ(verdict.kind, VerdictKind::kFault) << verdict.reason;
    EXPECT_TRUE(Names(verdict, paper::kRa)) << verdict.reason;
  }
}

// The magnet warms up too, by a tenth: J comes nearest to both together.
TEST(Warming, OfWindingAndMagnetIsNoOtherPart) {
  Rig rig = Settings().back().rig;
  rig.low_v = 2.0;
  rig.high_v = 3.0;
  rig.clock = 5;
  rig.physics = {.warming_per_s = 0.001, .magnet = 0.1};
  for (const unsigned seed : tests::Seeds(20, 29)) {
    const Diagnosis diagnosis =
        DiagnoseRecord(RecordFor(rig, rig, 10.0, 20.0, seed), paper::Options());
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal)
        << seed << ": " << diagnosis.verdict.reason;
    EXPECT_TRUE(diagnosis.episodes.empty()) << seed;
  }
}

// A gear motor of which the speed alone is read: it hardly tells Ra, J and Ke apart.
class WarmingSpeedMotor : public testing::Test {
 protected:
  WarmingSpeedMotor() : bench_(*hardware::LoadBench("speed-motor").value()) {
    rig_.clock = 5;
    rig_.physics = {.warming_per_s = 0.002, .magnet = 0.1};
  }

  Diagnosis Diagnose(const Rig& faulty, unsigned seed) const {
    return DiagnoseRecord(RecordFor(rig_, faulty, 10.0, 20.0, seed), OptionsOf(bench_));
  }

  const Bench& bench_;
  Rig rig_ = Settings().front().rig;
};

TEST_F(WarmingSpeedMotor, IsHealthy) {
  for (const unsigned seed : tests::Seeds(201, 213)) {
    const Diagnosis diagnosis = Diagnose(rig_, seed);
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal)
        << seed << ": " << diagnosis.verdict.reason;
    EXPECT_TRUE(diagnosis.episodes.empty()) << seed;
  }
}

TEST_F(WarmingSpeedMotor, HasItsFaultNamed) {
  Rig faulty = rig_;
  faulty.k *= 0.7;
  for (const unsigned seed : tests::Seeds(221, 233)) {
    const Verdict verdict = Diagnose(faulty, seed).verdict;
    EXPECT_EQ(verdict.kind, VerdictKind::kFault) << seed << ": " << verdict.reason;
    EXPECT_TRUE(Names(verdict, bench_.Find("k").value())) << seed << ": " << verdict.reason;
  }
}

}  // namespace
}  // namespace faultlab::core
