#include "core/diagnosis/diagnose_record.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <string>

#include "core/diagnosis/pipeline.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/paper_bench.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

struct PaperFault {
  Component component;
  double value;
  double tolerance;  // relative; 0: a bound is right
};

// The 18 faults of the paper's Tables 3 to 10. Ra x 10 and C8 at 1 uF change um least.
const std::vector<PaperFault>& AllPaperFaults() {
  static const std::vector<PaperFault> faults = {{paper::kR1, 10.0, 0.02},
                                                 {paper::kR1, 56.0, 0.02},
                                                 {paper::kR1, 100.0, 0.02},
                                                 {paper::kR9, 33e3, 0.02},
                                                 {paper::kR9, 56e3, 0.02},
                                                 {paper::kR9, 100e3, 0.03},
                                                 {paper::kR12, 2e3, 0.02},
                                                 {paper::kR12, 3.3e3, 0.02},
                                                 {paper::kR12, 5.6e3, 0.02},
                                                 {paper::kC8, 1e-6, 0.02},
                                                 {paper::kC8, 10e-6, 0.02},
                                                 {paper::kC8, 47e-6, 0.02},
                                                 {paper::kRa, 0.741, 0.12},
                                                 {paper::kRa, 74.1, 0.10},
                                                 {paper::kJ, 1.43e-4, 0.12},
                                                 {paper::kJ, 1.43e-8, 0.0},
                                                 {paper::kB, 1.8e-4, 0.05},
                                                 {paper::kB, 1.8e-5, 0.05}};
  return faults;
}

void ExpectAllPaperFaultsNamed(Channels channels, double delay_max_s) {
  std::uint64_t seed = 21;
  for (const PaperFault& fault : AllPaperFaults()) {
    const auto record = BenchRecord({AbruptFault(fault.component, fault.value)}, ++seed);
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(channels));
    const Verdict& verdict = diagnosis.verdict;
    SCOPED_TRACE(std::string(Name(fault.component)) + " = " + std::to_string(fault.value) + ": " +
                 verdict.reason);
    ASSERT_EQ(verdict.kind, VerdictKind::kFault);
    EXPECT_TRUE(Names(verdict, fault.component));
    ASSERT_TRUE(verdict.detected_at_s.has_value());
    EXPECT_GE(*verdict.detected_at_s, 10.0);
    EXPECT_LE(*verdict.detected_at_s, 10.0 + delay_max_s);
    if (fault.tolerance > 0.0) {
      EXPECT_NEAR(ValueOf(verdict, fault.component), fault.value, fault.tolerance * fault.value);
    } else {
      EXPECT_LT(ValueOf(verdict, fault.component), 2e-7);
    }
  }
}

TEST(DiagnoseRecord, NamesAndSizesEveryFaultOfThePaperFromUmAlone) {
  ExpectAllPaperFaultsNamed(Channels::kUmOnly, 0.3);
}

TEST(DiagnoseRecord, NamesEveryFaultOfThePaperWithinThreeSamplesFromAllChannels) {
  ExpectAllPaperFaultsNamed(Channels::kAll, 0.03);
}

TEST(DiagnoseRecord, SaysNominalOfAHealthyRig) {
  for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
    const Diagnosis diagnosis = DiagnoseRecord(BenchRecord({}, 5), FreeValues(channels));
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_FALSE(diagnosis.verdict.detected_at_s.has_value());
    EXPECT_TRUE(diagnosis.episodes.empty());
  }
}

TEST(DiagnoseRecord, CannotTellR9FromR12AndSaysBothValues) {
  const Diagnosis diagnosis =
      DiagnoseRecord(BenchRecord({AbruptFault(paper::kR9, 33e3)}, 6), FreeValues(Channels::kAll));
  EXPECT_EQ(diagnosis.verdict.group.size(), 2U);
  EXPECT_NEAR(ValueOf(diagnosis.verdict, paper::kR9), 33e3, 300.0);
  EXPECT_NEAR(ValueOf(diagnosis.verdict, paper::kR12), 5818.0, 30.0);
}

TEST(DiagnoseRecord, ResolvesR9AndR12ByTheValuesThatRelaysCanConnect) {
  DiagnosisOptions options = FreeValues(Channels::kUmOnly);
  options.values = ValuePrior::kTable2;
  const Diagnosis r9 = DiagnoseRecord(BenchRecord({AbruptFault(paper::kR9, 33e3)}, 7), options);
  EXPECT_EQ(r9.verdict.group, std::vector<Component>{paper::kR9}) << r9.verdict.reason;
  EXPECT_DOUBLE_EQ(r9.verdict.candidates.front().value, 33e3);
  const Diagnosis r12 = DiagnoseRecord(BenchRecord({AbruptFault(paper::kR12, 5.6e3)}, 8), options);
  EXPECT_EQ(r12.verdict.group, std::vector<Component>{paper::kR12}) << r12.verdict.reason;
}

TEST(DiagnoseRecord, KnowsThatAGainBelowHalfCanOnlyBeR12) {
  const Diagnosis diagnosis = DiagnoseRecord(BenchRecord({AbruptFault(paper::kR12, 2e3)}, 9),
                                             FreeValues(Channels::kUmOnly));
  EXPECT_EQ(diagnosis.verdict.group, std::vector<Component>{paper::kR12});
}

TEST(DiagnoseRecord, GivesABoundForAnInertiaTooSmallToSize) {
  const Diagnosis diagnosis = DiagnoseRecord(BenchRecord({AbruptFault(paper::kJ, 1.43e-8)}, 10),
                                             FreeValues(Channels::kAll));
  ASSERT_FALSE(diagnosis.verdict.candidates.empty());
  const Candidate& best = diagnosis.verdict.candidates.front();
  EXPECT_EQ(best.component, paper::kJ);
  EXPECT_EQ(best.bound, '<');
  EXPECT_LT(best.value, 3e-7);
  EXPECT_TRUE(std::isnan(best.sigma));
}

TEST(DiagnoseRecord, FollowsADrift) {
  Fault drift = AbruptFault(paper::kR9, 18e3, 6.0);
  drift.kind = FaultKind::kDrift;
  drift.until_s = 16.0;
  for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
    const Diagnosis diagnosis = DiagnoseRecord(BenchRecord({drift}, 11), FreeValues(channels));
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kFault) << diagnosis.verdict.reason;
    EXPECT_TRUE(Names(diagnosis.verdict, paper::kR9)) << diagnosis.verdict.reason;
    EXPECT_NEAR(ValueOf(diagnosis.verdict, paper::kR9), 18e3, 400.0);
    EXPECT_LT(*diagnosis.verdict.detected_at_s, 7.0);
    EXPECT_EQ(diagnosis.episodes.size(), 1U);
    EXPECT_EQ(diagnosis.verdict.reason.find("a second"), std::string::npos)
        << "it has ended: " << diagnosis.verdict.reason;
  }
}

TEST(DiagnoseRecord, StatesTheRateOfADriftThatGoesOn) {
  Fault drift = AbruptFault(paper::kR9, 18e3, 6.0);
  drift.kind = FaultKind::kDrift;
  drift.until_s = 26.0;  // the record ends at 20 s
  const std::string reason =
      DiagnoseRecord(BenchRecord({drift}, 13), FreeValues(Channels::kAll)).verdict.reason;
  const std::string begin = "and moves by +";
  const std::size_t at = reason.find(begin);
  ASSERT_NE(at, std::string::npos) << reason;
  EXPECT_NEAR(std::stod(reason.substr(at + begin.size())), 400.0, 100.0) << reason;
  EXPECT_NE(reason.find("ohm a second"), std::string::npos) << reason;
}

// A hundred times as much within 5 s, and the record ends a moment after that.
TEST(DiagnoseRecord, NamesASteepDriftWhileItMovesAndAtItsEnd) {
  Fault drift = AbruptFault(paper::kB, 1.8e-4, 10.0);
  drift.kind = FaultKind::kDrift;
  drift.until_s = 15.0;
  for (const std::size_t samples : {1300, 1400, 1540}) {
    auto record = BenchRecord({drift}, 15);
    record.resize(samples);
    const Verdict verdict = DiagnoseRecord(record, FreeValues(Channels::kAll)).verdict;
    SCOPED_TRACE(verdict.reason);
    ASSERT_EQ(verdict.kind, VerdictKind::kFault);
    EXPECT_TRUE(Names(verdict, paper::kB));
    const double now = std::min(1.8e-4, 1.8e-6 + 3.564e-5 * (record.back().t_s - 10.0));
    EXPECT_NEAR(ValueOf(verdict, paper::kB), now, 0.03 * now);
    const std::string begin = "and moves by +";
    const std::size_t at = verdict.reason.find(begin);
    ASSERT_EQ(at != std::string::npos, samples < 1500);
    if (samples > 1500) continue;
    EXPECT_NEAR(std::stod(verdict.reason.substr(at + begin.size())), 3.564e-5, 1e-6);
  }
}

TEST(DiagnoseRecord, LosesNoFaultWithTheSampleBeforeTheLast) {
  std::uint64_t seed = 81;
  for (const PaperFault& fault : AllPaperFaults()) {
    auto record = BenchRecord({AbruptFault(fault.component, fault.value)}, ++seed);
    record.erase(record.end() - 2);
    const Verdict verdict = DiagnoseRecord(record, FreeValues(Channels::kAll)).verdict;
    SCOPED_TRACE(std::string(Name(fault.component)) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kFault);
    EXPECT_TRUE(Names(verdict, fault.component));
  }
}

// The resistors around C8 decide how much of a step passes it at once; a healthy rig does not show
// it.
TEST(DiagnoseRecord, NamesALargeCapacitorAloneOnARigWhosePartsAreOff) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> off(0.96, 1.04);
  for (const unsigned seed : tests::Seeds(1, 21)) {
    PlantParameters rig = paper::Plant();
    for (int part = 0; part < rig.structure->parameter_count(); ++part) {
      rig.Set(part, rig.Get(part) * off(random));
    }
    rig.kt_nm_per_a = rig.ke_v_per_rad_s;
    const PrbsSpec wide{.low_v = 1.3, .high_v = 3.9, .seed = seed};
    const double value = seed % 2 == 0 ? 10e-6 : 47e-6;
    const std::vector<Sample> record =
        SimulateRecord(paper::Hardware(),
                       rig,
                       MakePrbs(wide, 2000, paper::kPeriodS),
                       std::vector<Fault>{AbruptFault(paper::kC8, value)},
                       seed,
                       paper::kPeriodS);
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(Channels::kAll));
    const Verdict& verdict = diagnosis.verdict;
    SCOPED_TRACE(std::to_string(seed) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kFault);
    EXPECT_TRUE(Names(verdict, paper::kC8));
    EXPECT_EQ(diagnosis.episodes.size(), 1U);
  }
}

TEST(DiagnoseRecord, SeesWhatFailsBesideALargeCapacitor) {
  const Fault capacitor = AbruptFault(paper::kC8, 10e-6);
  for (const PaperFault& other : {PaperFault{paper::kR1, 10.0, 0.03}, {paper::kJ, 4e-6, 0.03}}) {
    const auto at = [&](double at_s) {
      return DiagnoseRecord(
                 BenchRecord({capacitor, AbruptFault(other.component, other.value, at_s)}, 85),
                 FreeValues(Channels::kAll))
          .verdict;
    };
    const Verdict together = at(10.0);
    EXPECT_EQ(together.kind, VerdictKind::kUnknownFault) << together.reason;
    const Verdict later = at(15.0);
    EXPECT_EQ(later.kind, VerdictKind::kFault) << later.reason;
    EXPECT_TRUE(Names(later, other.component)) << later.reason;
    EXPECT_NE(later.reason.find("on top of C8"), std::string::npos) << later.reason;
    EXPECT_NEAR(ValueOf(later, other.component), other.value, other.tolerance * other.value);
  }
}

TEST(DiagnoseRecord, SaysThatTooLittleFollowsAChangeAtTheVeryEnd) {
  auto record = BenchRecord({AbruptFault(paper::kR1, 100.0)}, 14);
  record.erase(record.begin() + 1001, record.end());  // the fault begins at 10 s
  const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(Channels::kAll));
  EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kUnknownFault);
  EXPECT_NE(diagnosis.verdict.reason.find("too little follows"), std::string::npos)
      << diagnosis.verdict.reason;
  ASSERT_EQ(diagnosis.episodes.size(), 1U);
  EXPECT_EQ(diagnosis.episodes.front().verdict.reason, diagnosis.verdict.reason);
}

TEST(DiagnoseRecord, CallsADoubleFaultUnknown) {
  const Diagnosis diagnosis =
      DiagnoseRecord(BenchRecord({AbruptFault(paper::kR1, 5.0), AbruptFault(paper::kJ, 4e-6)}, 12),
                     FreeValues(Channels::kAll));
  EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kUnknownFault) << diagnosis.verdict.reason;
  EXPECT_TRUE(diagnosis.verdict.group.empty());
}

TEST(DiagnoseRecord, OfTwoThatFailTogetherUmAloneDoesNotTellWhich) {
  const std::vector<Fault> faults = {AbruptFault(paper::kRa, 4.0), AbruptFault(paper::kB, 2e-5)};
  int pairs = 0;
  for (const std::uint64_t seed : tests::Seeds(1, 5)) {
    const Verdict verdict =
        DiagnoseRecord(BenchRecord(faults, seed), FreeValues(Channels::kUmOnly)).verdict;
    SCOPED_TRACE(std::to_string(seed) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kUnknownFault);
    if (!verdict.reason.starts_with("two components have changed together")) continue;
    ++pairs;
    EXPECT_TRUE(verdict.reason.ends_with("with um alone, another pair is possible too"));
  }
  EXPECT_GT(pairs, 0);
}

TEST(DiagnoseRecord, SeesTheReturnToNominal) {
  Fault spell = AbruptFault(paper::kR1, 10.0, 8.0);
  spell.kind = FaultKind::kIntermittent;
  spell.until_s = 14.0;
  const Diagnosis diagnosis =
      DiagnoseRecord(BenchRecord({spell}, 13), FreeValues(Channels::kUmOnly));
  EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
  ASSERT_EQ(diagnosis.episodes.size(), 1U);
  EXPECT_TRUE(Names(diagnosis.episodes[0].verdict, paper::kR1));
  ASSERT_TRUE(diagnosis.episodes[0].ended_at_s.has_value());
  EXPECT_NEAR(*diagnosis.episodes[0].ended_at_s, 14.0, 0.3);
}

TEST(DiagnoseRecord, SeesASecondFaultAfterTheFirst) {
  const Diagnosis diagnosis = DiagnoseRecord(
      BenchRecord({AbruptFault(paper::kR1, 10.0, 8.0), AbruptFault(paper::kR12, 5.6e3, 14.0)}, 14),
      FreeValues(Channels::kAll));
  ASSERT_EQ(diagnosis.episodes.size(), 2U);
  EXPECT_TRUE(Names(diagnosis.episodes[0].verdict, paper::kR1));
  EXPECT_TRUE(Names(diagnosis.episodes[1].verdict, paper::kR12))
      << diagnosis.episodes[1].verdict.reason;
  EXPECT_NEAR(ValueOf(diagnosis.episodes[1].verdict, paper::kR12), 5.6e3, 60.0);
}

TEST(DiagnoseRecord, LearnsARigThatIsOffItsDataSheet) {
  PlantParameters rig = paper::Plant();
  rig.series_ohm *= 1.05;
  rig.Set(paper::kR12, rig.Get(paper::kR12) * 0.96);
  rig.ra_ohm *= 0.95;
  rig.j_kg_m2 *= 1.05;
  for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
    const Diagnosis diagnosis = DiagnoseRecord(
        BenchRecord({AbruptFault(paper::kJ, 4e-6)}, 15, 20.0, rig), FreeValues(channels));
    EXPECT_EQ(diagnosis.verdict.group, std::vector<Component>{paper::kJ})
        << diagnosis.verdict.reason;
    EXPECT_NEAR(ValueOf(diagnosis.verdict, paper::kJ), 4e-6, 0.2e-6);
  }
}

TEST(DiagnoseRecord, StatesACapacitorNoCloserThanTheResistorsBesideItAreKnown) {
  PlantParameters rig = paper::Plant();
  rig.Set(paper::kR12, rig.Get(paper::kR12) * 0.96);
  rig.Set(paper::kR9, rig.Get(paper::kR9) * 1.03);
  for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
    const Diagnosis diagnosis = DiagnoseRecord(
        BenchRecord({AbruptFault(paper::kC8, 10e-6)}, 31, 20.0, rig), FreeValues(channels));
    ASSERT_FALSE(diagnosis.verdict.candidates.empty());
    const Candidate& best = diagnosis.verdict.candidates.front();
    ASSERT_EQ(best.component, paper::kC8) << diagnosis.verdict.reason;
    EXPECT_NEAR(best.value, 10e-6, 3.0 * best.sigma);
    EXPECT_LT(best.sigma, 1e-6);
  }
}

TEST(DiagnoseRecord, LivesWithMissingRepeatedAndBrokenSamples) {
  std::vector<Sample> record = BenchRecord({AbruptFault(paper::kR1, 10.0)}, 16);
  std::vector<Sample> damaged;
  for (const Sample& sample : record) {
    if (sample.index % 97 == 50) continue;  // lost
    damaged.push_back(sample);
    if (sample.index % 89 == 20) damaged.push_back(sample);  // repeated
    if (sample.index % 61 == 7) damaged.back().um_v = std::numeric_limits<double>::quiet_NaN();
    if (sample.index % 127 == 9) damaged.back().uc_v = std::numeric_limits<double>::infinity();
  }
  for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
    const Diagnosis diagnosis = DiagnoseRecord(damaged, FreeValues(channels));
    EXPECT_EQ(diagnosis.verdict.group, std::vector<Component>{paper::kR1})
        << diagnosis.verdict.reason;
    EXPECT_NEAR(ValueOf(diagnosis.verdict, paper::kR1), 10.0, 0.3);
    EXPECT_GE(*diagnosis.verdict.detected_at_s, 10.0);
  }
}

TEST(DiagnoseRecord, TakesAReadingAtTheRailForABound) {
  // k = 4.0: 12 V at 3 V input, but the converter's range ends at 10 V.
  const std::vector<Sample> record = BenchRecord({AbruptFault(paper::kR12, 18e3)}, 17);
  for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(channels));
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kFault) << diagnosis.verdict.reason;
    EXPECT_TRUE(Names(diagnosis.verdict, paper::kR12)) << diagnosis.verdict.reason;
    EXPECT_NEAR(ValueOf(diagnosis.verdict, paper::kR12), 18e3, 400.0);
  }
}

TEST(DiagnoseRecord, SaysNotExcitedUnderAConstantInput) {
  std::vector<double> uc(2000, 2.5);
  const auto record =
      SimulateRecord(paper::Hardware(), paper::Plant(), uc, {}, 18, paper::kPeriodS);
  const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(Channels::kAll));
  EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNotExcited);
  ASSERT_TRUE(diagnosis.calibration_refusal.has_value());
  EXPECT_EQ(diagnosis.calibration_refusal->field, "excitation");
}

TEST(DiagnoseRecord, RefusesARecordShorterThanTheWindow) {
  const auto record = BenchRecord({}, 19, 1.0);
  const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(Channels::kAll));
  ASSERT_TRUE(diagnosis.calibration_refusal.has_value());
  EXPECT_EQ(diagnosis.calibration_refusal->field, "length");
  EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kCalibrating) << "nothing is said of its input";
  EXPECT_FALSE(diagnosis.calibration.has_value());
  EXPECT_FALSE(DiagnoseRecord({}, FreeValues(Channels::kAll)).calibration.has_value());
}

TEST(DiagnoseRecord, RefusesAHealthyStretchThatHoldsAFault) {
  const auto record = BenchRecord({AbruptFault(paper::kR1, 10.0, 3.0)}, 20);
  for (Channels channels : {Channels::kUmOnly, Channels::kAll}) {
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(channels));
    ASSERT_TRUE(diagnosis.calibration_refusal.has_value());
    EXPECT_NE(diagnosis.verdict.kind, VerdictKind::kNominal);
  }
}

}  // namespace
}  // namespace faultlab::core
