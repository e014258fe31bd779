// Benches that are not among the shipped ones and whose motors turn one way.
#include "tests/core/diagnosis/unseen_rig.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

// A 200 W motor at 24 V of 48 V, 5 ms: currents of tens of ampere, no voltage measured.
constexpr const char* kBig = R"(
[bench]
name = "big"
structure = "motor-driver"
period_s = 0.005
delta_s = 0.004
input_max_v = 5.0
output_min_v = -48.0
output_max_v = 48.0
[plant]
Rs = 0.0
Ra = 0.32
La = 0.6e-3
Ke = 0.07
KT = 0.07
J = 3.5e-4
B = 2e-4
k = 10.0
[[component]]
symbol = "Ra"
[[component]]
symbol = "Ke"
and_with_it = "KT"
[[component]]
symbol = "J"
[[component]]
symbol = "k"
[channel.ia]
noise = 50e-3
range = [-60.0, 60.0]
[channel.n]
noise = 1.0
[norm]
gain = 0.02
Ra = 0.08
J = 0.08
B = 0.3
Ke = 0.04
mc_nm = 20e-3
mc_sigma_nm = 10e-3
friction_noise_nm = 1e-3
)";
constexpr Rig kBigRig = {0.005, 0.004, 10.1, 0.0, 0.34, 0.63e-3, 0.068, 0.068, 3.7e-4, 1.7e-4,
                         23e-3, -48.0, 48.0, 1.0, 2.0,  10,      50e-3, 60.0,  1.0,    false};

TEST(UnseenBench, BigMotorIsNominalWithoutAFault) {
  for (const unsigned seed : tests::Seeds(1, 5)) {
    const Diagnosis diagnosis = Diagnose(BenchOf(kBig), Record(kBigRig, kBigRig, seed));
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value());
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_TRUE(diagnosis.episodes.empty());
  }
}

TEST(UnseenBench, WithoutAVoltageTheRigIsWithinItsStatedErrors) {
  // k, Ra, Ke, J, B and Mc may all be scaled alike: tolerances alone say by how much.
  const Diagnosis diagnosis = Diagnose(BenchOf(kBig), Record(kBigRig, kBigRig, 4));
  ASSERT_TRUE(diagnosis.calibration.has_value());
  const auto expect = [&](const char* name, double value) {
    for (const CalibratedQuantity& q : diagnosis.calibration->quantities) {
      if (q.name == name) {
        EXPECT_NEAR(q.value, value, 2.5 * q.sigma) << name;
      }
    }
  };
  expect("k", kBigRig.k);
  expect("Ra", kBigRig.ra);
  expect("Ke", kBigRig.ke);
  expect("J", kBigRig.j);
}

TEST(UnseenBench, ReadingsNoisierThanDescribedAreNoFriction) {
  std::string text = kBig;
  const std::string noise = "noise = 1.0";
  text.replace(text.find(noise), noise.size(), "noise = 0.1");
  for (const unsigned seed : tests::Seeds(4, 8)) {
    const Diagnosis diagnosis = Diagnose(BenchOf(text), Record(kBigRig, kBigRig, seed));
    ASSERT_TRUE(diagnosis.calibration.has_value()) << diagnosis.calibration_refusal->message;
    EXPECT_LT(diagnosis.calibration->friction_noise_nm, 5e-3) << seed;
    for (const CalibratedQuantity& q : diagnosis.calibration->quantities) {
      if (q.name == "k") {
        EXPECT_NEAR(q.value, kBigRig.k, 2.5 * q.sigma) << seed;
      }
    }
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
  }
}

TEST(UnseenBench, SupplyThatEndsHidesNoFaultOfTheGain) {
  Rig faulty = kBigRig;
  faulty.k = 30.0;  // 60 V are asked for, 48 V come
  ExpectNamed(BenchOf(kBig), Record(kBigRig, faulty, 5), "k", faulty.k, 0.05);
}

TEST(UnseenBench, FasterMotorIsReadMoreCoarselyAndHasOneFault) {
  // 1000 pulses a revolution, 40 MHz: the rounding is 6 rpm at 700 rad/s, 1 rpm while healthy. The
  // known fault is watched with that too.
  Rig healthy = kBigRig;
  healthy.speed_step_s = 1000.0 / (2.0 * std::numbers::pi * 40e6);
  Rig faulty = healthy;
  faulty.k = 30.0;
  ExpectNamed(BenchOf(kBig), Record(healthy, faulty, 10), "k", faulty.k, 0.05);
  faulty = healthy;
  faulty.ke = faulty.kt = 0.021;
  ExpectNamed(BenchOf(kBig), Record(healthy, faulty, 11), "Ke", faulty.ke, 0.05);
}

double LogErrorOf(const Verdict& verdict, const Bench& bench, const char* symbol, double value) {
  return std::log(ValueOf(verdict, bench.Find(symbol).value()) / value);
}

TEST(UnseenBench, WithoutAVoltageAFaultIsOffByTheCommonFactorAlone) {
  // The noise of friction must not decide by which factor all parameters are scaled.
  const Bench& bench = BenchOf(kBig);
  Rig healthy = kBigRig;
  healthy.friction_noise_nm = 2e-3;
  for (const unsigned seed : tests::Seeds(12, 16)) {
    Rig faulty = healthy;
    faulty.j = 1.4e-3;
    const Diagnosis diagnosis = Diagnose(bench, Record(healthy, faulty, seed));
    ASSERT_EQ(diagnosis.verdict.kind, VerdictKind::kFault) << diagnosis.verdict.reason;
    const double common = std::log(diagnosis.calibration->nominal.gain() *
                                   diagnosis.calibration->gain_factor / healthy.k);
    EXPECT_NEAR(LogErrorOf(diagnosis.verdict, bench, "J", faulty.j), common, 0.001) << seed;
  }
}

TEST(UnseenBench, WithoutAVoltageTheGainsErrorIncludesTheCommonFactor) {
  const Bench& bench = BenchOf(kBig);
  Rig faulty = kBigRig;
  faulty.k = 7.0;
  const Diagnosis diagnosis = Diagnose(bench, Record(kBigRig, faulty, 16));
  ASSERT_EQ(diagnosis.verdict.kind, VerdictKind::kFault) << diagnosis.verdict.reason;
  const Candidate& k = diagnosis.verdict.candidates.front();
  ASSERT_EQ(Name(k.component), "k");
  // Tolerances of 2 % of the gain, 4 % of Ke, 8 % of Ra and J: 1.7 % together.
  EXPECT_NEAR(k.sigma / k.value, 0.017, 0.003);
  EXPECT_NEAR(k.value, faulty.k, 2.5 * k.sigma);
}

TEST(UnseenBench, CurrentBeyondItsConverterIsNoReading) {
  Rig faulty = kBigRig;
  faulty.ra = 0.032;  // a step of 10 V drives more than 60 A
  ExpectNamed(BenchOf(kBig), Record(kBigRig, faulty, 6), "Ra", faulty.ra, 0.08);
}

// A small motor with a shunt, all channels, 1 ms: La/(Ra + Rs) is a tenth of a period, and four
// tenths after a short circuit of the winding.
constexpr const char* kFast = R"(
[bench]
name = "fast"
structure = "motor-driver"
period_s = 0.001
delta_s = 0.0004
input_max_v = 5.0
[plant]
Rs = 0.2
Ra = 2.3
La = 0.24e-3
Ke = 23.4e-3
KT = 23.4e-3
J = 4e-6
B = 4e-6
k = 5.0
[[component]]
symbol = "Ra"
[[component]]
symbol = "Rs"
[[component]]
symbol = "Ke"
and_with_it = "KT"
[[component]]
symbol = "J"
[[component]]
symbol = "B"
[channel.um]
noise = 10e-3
range = [-25.0, 25.0]
[channel.ia]
noise = 5e-3
range = [-12.0, 12.0]
[channel.n]
noise = 1.0
[norm]
gain = 0.02
series = 0.02
Ra = 0.06
J = 0.08
B = 0.3
Ke = 0.04
La = 0.10
mc_nm = 0.8e-3
mc_sigma_nm = 0.4e-3
friction_noise_nm = 0.03e-3
)";
constexpr Rig kFastRig = {0.001,  0.0004, 5.05, 0.2, 2.2, 0.26e-3, 23.0e-3, 23.0e-3, 3.8e-6, 4.6e-6,
                          0.9e-3, -24.0,  24.0, 1.0, 2.0, 10,      5e-3,    12.0,    1.0,    true};

TEST(UnseenBench, InductanceWithinItsToleranceIsNoSecondFault) {
  Rig faulty = kFastRig;
  faulty.ra = 0.23;
  ExpectNamed(BenchOf(kFast), Record(kFastRig, faulty, 7), "Ra", faulty.ra, 0.03);
}

TEST(UnseenBench, OneFaultOfTheMotorConstantIsNotTwo) {
  Rig faulty = kFastRig;
  faulty.ke = faulty.kt = 0.07;
  ExpectNamed(BenchOf(kFast), Record(kFastRig, faulty, 8), "Ke", faulty.ke, 0.03);
}

// Geared cheap motor at 20 ms: friction is a third of what the drive gives.
constexpr const char* kStalling = R"(
[bench]
name = "stalling"
structure = "motor-driver"
period_s = 0.02
delta_s = 0.015
input_max_v = 5.0
output_min_v = 0.0
output_max_v = 12.0
[plant]
Rs = 0.5
Ra = 6.0
La = 2e-3
Ke = 11e-3
KT = 11e-3
J = 1.5e-6
B = 1e-6
k = 2.4
[[component]]
symbol = "Ra"
[[component]]
symbol = "Ke"
and_with_it = "KT"
[[component]]
symbol = "J"
[[component]]
symbol = "k"
[channel.um]
noise = 10e-3
range = [-15.0, 15.0]
[channel.ia]
noise = 5e-3
range = [-3.0, 3.0]
[channel.n]
noise = 3.0
[norm]
gain = 0.03
Ra = 0.10
J = 0.15
B = 0.5
Ke = 0.05
mc_nm = 1.0e-3
mc_sigma_nm = 0.4e-3
friction_noise_nm = 0.05e-3
)";
constexpr Rig kStallingRig = {0.02,   0.015, 2.35, 0.5, 6.3, 2e-3, 10.7e-3, 10.7e-3, 1.6e-6, 1.2e-6,
                              1.1e-3, 0.0,   12.0, 1.0, 3.0, 4,    5e-3,    3.0,     3.0,    true};

TEST(UnseenBench, MotorThatComesToRestTellsWhatStoppedIt) {
  Rig faulty = kStallingRig;
  faulty.ra = 63.0;  // 1 V of input no more overcomes friction, 3 V hardly
  ExpectNamed(BenchOf(kStalling), Record(kStallingRig, faulty, 9), "Ra", faulty.ra, 0.05);
}

TEST(UnseenBench, ColumnsThatTheDescriptionDoesNotNameAreNotUsed) {
  std::vector<Sample> record = Record(kBigRig, kBigRig, 1);
  for (Sample& sample : record) sample.um_v = 10.0 * sample.uc_v;
  const Diagnosis diagnosis = Diagnose(BenchOf(kBig), record);
  ASSERT_TRUE(diagnosis.calibration.has_value());
  EXPECT_FALSE(diagnosis.calibration->used_um);
  EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
}

TEST(UnseenBench, WithoutAVoltageAgreementByChanceTellsNothingOfTheCommonFactor) {
  Rig as_its_data_sheet = {0.005, 0.004, 10.0, 0.0, 0.32, 0.6e-3, 0.07,  0.07, 3.5e-4, 2e-4,
                           20e-3, -48.0, 48.0, 1.0, 2.0,  10,     50e-3, 60.0, 1.0,    false};
  const Diagnosis diagnosis =
      Diagnose(BenchOf(kBig), Record(as_its_data_sheet, as_its_data_sheet, 3));
  ASSERT_TRUE(diagnosis.calibration.has_value());
  for (const CalibratedQuantity& q : diagnosis.calibration->quantities) {
    if (q.name == "k" || q.name == "Ke") {
      EXPECT_GT(q.sigma, 0.012 * q.value) << q.name;
    }
    if (q.name == "delta") {
      EXPECT_EQ(q.prior_value, 0.004);
    }
  }
}

}  // namespace
}  // namespace faultlab::core
