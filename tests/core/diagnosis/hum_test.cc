// Mains hum in um and ia, near half the sampling rate: its phase turns against the rows, and its
// frequency moves as that of the mains does.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "core/diagnosis/diagnose_record.h"
#include "core/filter/hum_tracker.h"
#include "core/filter/rig_parameters.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/paper_bench.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

constexpr double kTau = 2.0 * std::numbers::pi;

struct Mains {
  double hz = 50.04;
  double um_v = 0.045;
  double ia_a = 0.005;
  double phase = 0.0;
  double wander_hz = 0.01;  ///< slowly, up and down in 40 s
};

std::vector<Sample> WithHum(std::vector<Sample> record, const Mains& mains) {
  constexpr double kWanderS = 40.0;
  for (Sample& sample : record) {
    const double wander =
        mains.wander_hz * kWanderS * std::sin(kTau * sample.t_s / kWanderS) / kTau;
    const double phase = kTau * (mains.hz * sample.t_s + wander) + mains.phase;
    sample.um_v += mains.um_v * std::sin(phase);
    sample.ia_a += mains.ia_a * std::sin(phase + 0.7);
  }
  return record;
}

class Humming : public testing::TestWithParam<Channels> {};

TEST_P(Humming, IsLearntTakenOutAndFollowed) {
  std::uint64_t seed = 101;
  for (const double hz : {49.9, 50.04, 50.3, 59.98, 60.2}) {
    const Mains mains{.hz = hz, .phase = static_cast<double>(seed)};
    const auto record = WithHum(BenchRecord({}, ++seed, 60.0), mains);
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(GetParam()));
    SCOPED_TRACE(hz);
    ASSERT_TRUE(diagnosis.calibration) << diagnosis.verdict.reason;
    const Calibration& learnt = *diagnosis.calibration;
    // 100 readings a second do not tell 49.7 Hz from 50.3 Hz.
    EXPECT_NEAR(std::abs(learnt.hum.frequency_hz - 50.0), std::abs(hz - 50.0), 0.03);
    EXPECT_NEAR(learnt.hum.um.amplitude(), mains.um_v, 0.25 * mains.um_v);
    EXPECT_LT(learnt.um_noise_v, 0.0165) << "hum is no noise";
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_FALSE(diagnosis.verdict.detected_at_s);
    EXPECT_TRUE(diagnosis.episodes.empty());
  }
}

TEST_P(Humming, HidesNoFaultAndMovesNoValue) {
  const std::pair<Component, double> faults[] = {
      {paper::kR12, 5.6e3}, {paper::kR1, 56.0}, {paper::kRa, 14.8}, {paper::kJ, 1.43e-5}};
  std::uint64_t seed = 111;
  for (const auto& [component, value] : faults) {
    ++seed;
    const Mains mains{.hz = seed % 2 == 0 ? 50.06 : 49.93, .phase = static_cast<double>(seed)};
    const auto record = WithHum(BenchRecord({AbruptFault(component, value)}, seed), mains);
    const Verdict verdict = DiagnoseRecord(record, FreeValues(GetParam())).verdict;
    SCOPED_TRACE(std::string(Name(component)) + ": " + verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kFault);
    EXPECT_TRUE(Names(verdict, component));
    EXPECT_NEAR(ValueOf(verdict, component), value, 0.03 * value);
    ASSERT_TRUE(verdict.detected_at_s);
    EXPECT_GE(*verdict.detected_at_s, 10.0);
  }
}

// Strong, and so near half the rate that seconds of it hardly tell its frequency: after the fault
// nobody can follow it.
TEST_P(Humming, ThatIsNotFollowedHidesNoFault) {
  std::uint64_t seed = 131;
  for (const double hz : {49.97, 50.03, 50.04}) {
    const Mains mains{
        .hz = hz, .um_v = 0.09, .ia_a = 0.01, .phase = static_cast<double>(seed), .wander_hz = 0.0};
    for (const auto& [component, value] :
         {std::pair{paper::kRa, 9.6}, std::pair{paper::kR1, 10.0}, std::pair{paper::kJ, 8.6e-7}}) {
      const auto record = WithHum(BenchRecord({AbruptFault(component, value)}, ++seed), mains);
      const Verdict verdict = DiagnoseRecord(record, FreeValues(GetParam())).verdict;
      SCOPED_TRACE(std::to_string(hz) + " Hz, " + std::string(Name(component)) + ": " +
                   verdict.reason);
      EXPECT_EQ(verdict.kind, VerdictKind::kFault);
      EXPECT_TRUE(Names(verdict, component));
      EXPECT_NEAR(ValueOf(verdict, component), value, 0.08 * value);
    }
  }
}

TEST_P(Humming, IsFoundBehindAnImpulse) {
  for (const std::uint64_t seed : tests::Seeds(121, 124)) {
    const Mains mains{.hz = 50.06, .phase = static_cast<double>(seed)};
    std::vector<Sample> record = WithHum(BenchRecord({}, seed), mains);
    record[215].um_v += 2.5;
    const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(GetParam()));
    ASSERT_TRUE(diagnosis.calibration) << diagnosis.verdict.reason;
    EXPECT_TRUE(diagnosis.calibration->hum.any());
    EXPECT_GT(diagnosis.calibration->impulse_share, 0.0);
    EXPECT_LT(diagnosis.calibration->um_noise_v, 0.0165);
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
  }
}

TEST_P(Humming, IsNotFoundWhereThereIsNone) {
  for (const std::uint64_t seed : tests::Seeds(121, 127)) {
    const Diagnosis diagnosis = DiagnoseRecord(BenchRecord({}, seed), FreeValues(GetParam()));
    ASSERT_TRUE(diagnosis.calibration);
    EXPECT_FALSE(diagnosis.calibration->hum.any()) << diagnosis.calibration->hum.frequency_hz;
  }
}

TEST_P(Humming, IsSaidInPlainNumbers) {
  const auto record = WithHum(BenchRecord({}, 128), {.hz = 60.1, .um_v = 0.5, .ia_a = 0.05});
  const Diagnosis diagnosis = DiagnoseRecord(record, FreeValues(GetParam()));
  ASSERT_TRUE(diagnosis.calibration);
  std::string said;
  for (const CalibrationCheck& check : diagnosis.calibration->checks) {
    if (check.name == "hum") said = check.sentence;
  }
  EXPECT_EQ(said.rfind("hum of 60.1", 0), 0u) << said;
  EXPECT_NE(said.find(" mV of um"), std::string::npos) << said;
  EXPECT_EQ(said.find("e+"), std::string::npos) << said;
}

// The phase of one run says nothing of that of another.
TEST_P(Humming, IsNoiseToTheCalibrationOfAnotherRun) {
  const DiagnosisOptions options = FreeValues(GetParam());
  const Diagnosis first = DiagnoseRecord(WithHum(BenchRecord({}, 131), {.phase = 0.4}), options);
  ASSERT_TRUE(first.calibration);
  DiagnosisOptions with = options;
  with.calibration = *first.calibration;
  const Diagnosis other = DiagnoseRecord(WithHum(BenchRecord({}, 132), {.phase = 3.5}), with);
  ASSERT_TRUE(other.calibration);
  EXPECT_FALSE(other.calibration->hum.any());
  EXPECT_GT(other.calibration->um_noise_v, 0.03);
  EXPECT_EQ(other.verdict.kind, VerdictKind::kNominal) << other.verdict.reason;
}

INSTANTIATE_TEST_SUITE_P(Channels,
                         Humming,
                         testing::Values(Channels::kUmOnly, Channels::kAll),
                         [](const auto& channels) {
                           return channels.param == Channels::kAll ? "All" : "UmOnly";
                         });

// Without noise: after 60 s it goes on by itself for ten more.
TEST(HumTracker, FollowsTheMainsAndLearnsTheirFrequency) {
  const Hum mains{60.04, {0.03, -0.02}, {0.002, 0.004}};
  Hum slower = mains;
  slower.frequency_hz = 60.03;
  HumTracker tracker(slower, {.um_v = 0.015, .ia_a = 0.0015}, 0.01);
  double most_v = 0.0;
  for (int k = 0; k < 7000; ++k) {
    Sample zero;
    zero.t_s = 0.01 * k;
    zero.um_v = 0.0;
    zero.ia_a = 0.0;
    Sample reading = WithoutHum(zero, mains);
    reading.um_v *= -1.0;
    reading.ia_a *= -1.0;
    const Sample left = tracker.Clean(reading);
    if (k < 6000) tracker.Learn(zero.t_s, left.um_v, left.ia_a);
    if (k > 2000) most_v = std::max(most_v, std::abs(left.um_v));
  }
  EXPECT_LT(most_v, 0.05 * mains.um.amplitude());
  EXPECT_NEAR(tracker.hum().frequency_hz, mains.frequency_hz, 1e-4);
}

}  // namespace
}  // namespace faultlab::core
