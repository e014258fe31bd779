// Readings that are off one at a time: a contact, a relay that switches beside the wire.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/diagnosis/diagnose_record.h"
#include "core/signals/random.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/paper_bench.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

constexpr double kSizeV = 2.0;

/// Every reading of um is off by up to kSizeV with this probability.
std::vector<Sample> WithImpulses(std::vector<Sample> record, double share, std::uint64_t seed) {
  Random random(seed);
  for (Sample& sample : record) {
    if (random.Uniform(0.0, 1.0) >= share) continue;
    const double off = random.Uniform(0.3, 1.0) * kSizeV;
    sample.um_v += random.Uniform(0.0, 1.0) < 0.5 ? off : -off;
  }
  return record;
}

class Impulses : public testing::TestWithParam<Channels> {};

TEST_P(Impulses, OfAHealthyRigRaiseNoAlarm) {
  for (const std::uint64_t seed : tests::Seeds(81, 85)) {
    const auto record = WithImpulses(BenchRecord({}, seed), 0.01, seed);
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(GetParam()));
    ASSERT_TRUE(diagnosis.calibration) << diagnosis.verdict.reason;
    EXPECT_GT(diagnosis.calibration->impulse_share, 0.0);
    EXPECT_LT(diagnosis.calibration->um_noise_v, 0.018) << "impulses are no noise";
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_FALSE(diagnosis.verdict.detected_at_s);
  }
}

// A filter that begins takes any reading: the self-check begins anew in each quarter of the
// stretch.
TEST_P(Impulses, MayComeWhereTheSelfCheckBegins) {
  std::uint64_t seed = 85;
  for (const double t_s : {0.5, 1.63, 2.75, 3.88}) {
    std::vector<Sample> record = BenchRecord({}, ++seed);
    for (const double off_s : {t_s, 4.5}) {
      record[static_cast<std::size_t>(std::lround(off_s / paper::kPeriodS))].um_v += kSizeV;
    }
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(GetParam()));
    ASSERT_TRUE(diagnosis.calibration) << t_s << ": " << diagnosis.verdict.reason;
    EXPECT_LT(diagnosis.calibration->um_noise_v, 0.018) << t_s;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << t_s;
  }
}

// In the first record there are none in the stretch that is learnt from.
TEST_P(Impulses, HideNoFault) {
  const std::pair<Component, double> faults[] = {
      {paper::kR12, 5.6e3}, {paper::kR1, 56.0}, {paper::kC8, 10e-6}, {paper::kJ, 1.43e-5}};
  std::uint64_t seed = 91;
  for (const auto& [component, value] : faults) {
    ++seed;
    const auto record =
        WithImpulses(BenchRecord({AbruptFault(component, value)}, seed), 0.01, seed);
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(GetParam()));
    const Verdict& verdict = diagnosis.verdict;
    SCOPED_TRACE(std::string(Name(component)) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kFault);
    EXPECT_TRUE(Names(verdict, component));
    EXPECT_NEAR(ValueOf(verdict, component), value, 0.12 * value);
    ASSERT_TRUE(verdict.detected_at_s);
    EXPECT_GE(*verdict.detected_at_s, 10.0);
    EXPECT_LE(*verdict.detected_at_s, 10.5);
  }
}

TEST_P(Impulses, HideNoDrift) {
  for (const std::uint64_t seed : tests::Seeds(96, 100)) {
    Fault drift = AbruptFault(paper::kR9, 18e3, 5.0);
    drift.kind = FaultKind::kDrift;
    drift.until_s = seed % 2 == 0 ? 17.0 : 26.0;  // the record ends at 20 s
    const double last = drift.until_s < 20.0 ? drift.value : 10e3 + 8e3 * 15.0 / 21.0;
    const auto record = WithImpulses(BenchRecord({drift}, seed), 0.004, seed);
    DiagnosisOptions options = FreeValues(GetParam());
    options.healthy_to_s = 4.0;
    const Verdict verdict = DiagnoseRecord(record, options).verdict;
    SCOPED_TRACE(std::to_string(seed) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kFault);
    EXPECT_TRUE(Names(verdict, paper::kR9));
    EXPECT_NEAR(ValueOf(verdict, paper::kR9), last, 0.03 * last);
  }
}

/// Of um, at `t_s`, in a record whose healthy stretch had none.
std::vector<Sample> WithImpulseAt(std::vector<Sample> record, double t_s) {
  record[static_cast<std::size_t>(std::lround(t_s / paper::kPeriodS))].um_v += kSizeV;
  return record;
}

// The alarm that the first one raises is over before the fault begins: the fault has its own time.
TEST_P(Impulses, AreForgottenAfterHalfASecond) {
  for (const std::uint64_t seed : tests::Seeds(121, 129)) {
    const auto record = WithImpulseAt(BenchRecord({AbruptFault(paper::kRa, 9.6, 10.0)}, seed), 9.3);
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(GetParam()));
    const Verdict& verdict = diagnosis.verdict;
    SCOPED_TRACE(std::to_string(seed) + ": " + verdict.reason);
    EXPECT_TRUE(Names(verdict, paper::kRa));
    ASSERT_TRUE(verdict.detected_at_s);
    EXPECT_GE(*verdict.detected_at_s, 10.0);
    EXPECT_EQ(diagnosis.episodes.size(), 1U);
  }
}

// However little follows the last one.
TEST_P(Impulses, JustBeforeTheEndTakeNoFaultBack) {
  const std::pair<Component, double> faults[] = {
      {paper::kR12, 5.6e3}, {paper::kR1, 56.0}, {paper::kRa, 15.0}, {paper::kJ, 1.43e-5}};
  std::uint64_t seed = 151;
  for (const auto& [component, value] : faults) {
    for (const double left_s : {0.35, 0.2, 0.12, 0.06, 0.03, 0.01}) {
      const auto without = BenchRecord({AbruptFault(component, value)}, ++seed);
      const auto record = WithImpulseAt(without, 20.0 - left_s);
      const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(GetParam()));
      const Verdict& verdict = diagnosis.verdict;
      SCOPED_TRACE(std::string(Name(component)) + ": " + verdict.reason);
      EXPECT_EQ(verdict.kind, VerdictKind::kFault);
      EXPECT_TRUE(Names(verdict, component));
      ASSERT_TRUE(verdict.detected_at_s);
      EXPECT_LT(*verdict.detected_at_s, 10.5);
      EXPECT_EQ(diagnosis.episodes.size(), 1U);
    }
  }
}

// What the end of a fault raises is no impulse: the next fault is still seen in its first sample.
TEST_P(Impulses, AreNotWhatTheEndOfAFaultRaises) {
  Fault first = AbruptFault(paper::kR1, 56.0, 8.0);
  first.kind = FaultKind::kIntermittent;
  first.until_s = 11.0;
  for (const std::uint64_t seed : tests::Seeds(171, 175)) {
    const auto record = BenchRecord({first, AbruptFault(paper::kR1, 56.0, 17.0)}, seed);
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(GetParam()));
    SCOPED_TRACE(std::to_string(seed) + ": " + diagnosis.verdict.reason);
    ASSERT_EQ(diagnosis.episodes.size(), 2U);
    ASSERT_TRUE(diagnosis.verdict.detected_at_s);
    EXPECT_NEAR(*diagnosis.verdict.detected_at_s, 17.0, 0.011);
  }
}

INSTANTIATE_TEST_SUITE_P(Channels, Impulses, testing::Values(Channels::kUmOnly, Channels::kAll));

TEST(ImpulsesOfARecord, AreNotFoundWhereThereAreNone) {
  for (const std::uint64_t seed : tests::Seeds(101, 111)) {
    const Diagnosis diagnosis =
        DiagnoseRecord(BenchRecord({}, seed, 6.0), FreeValues(Channels::kAll));
    ASSERT_TRUE(diagnosis.calibration);
    EXPECT_EQ(diagnosis.calibration->impulse_share, 0.0);
  }
}

TEST(ImpulsesOfARecord, ThatAreEverywhereAreRefusedInASentence) {
  const auto record = WithImpulses(BenchRecord({}, 111, 8.0), 0.3, 111);
  const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(Channels::kUmOnly));
  EXPECT_FALSE(diagnosis.calibration);
  EXPECT_NE(diagnosis.verdict.reason.find("not calibrated, check '"), std::string::npos)
      << diagnosis.verdict.reason;
}

}  // namespace
}  // namespace faultlab::core
