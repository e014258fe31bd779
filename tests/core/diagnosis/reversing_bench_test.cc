// Benches that are not among the shipped ones and whose motors turn both ways.
#include "tests/core/diagnosis/unseen_rig.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

// A small motor that turns both ways, 2 ms: it passes through rest many times a second.
constexpr const char* kBothWays = R"(
[bench]
name = "both-ways"
structure = "motor-driver"
period_s = 0.002
delta_s = 0.001
input_min_v = -5.0
input_max_v = 5.0
output_min_v = -24.0
output_max_v = 24.0
[plant]
Rs = 0.0
Ra = 2.3
La = 0.24e-3
Ke = 23.4e-3
KT = 23.4e-3
J = 11e-6
B = 5e-6
k = 4.0
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
noise = 5e-3
range = [-12.0, 12.0]
[channel.n]
noise = 1.0
pulses_per_revolution = 250
[norm]
gain = 0.02
Ra = 0.05
J = 0.05
B = 0.3
Ke = 0.03
mc_nm = 2.0e-3
mc_sigma_nm = 1.0e-3
friction_noise_nm = 0.2e-3
)";
constexpr Rig kBothWaysRig = {0.002,   0.001,   4.04,
                              0.0,     2.2,     0.26e-3,
                              23.0e-3, 23.0e-3, 11.4e-6,
                              5.5e-6,  2.3e-3,  -24.0,
                              24.0,    -0.5,    0.5,
                              15,      5e-3,    12.0,
                              1.0,     false,   250.0 / (2.0 * std::numbers::pi * 40e6),
                              0.2e-3,  2.8e-3,  2.0 * std::numbers::pi / (250.0 * 0.01)};

TEST(ReversingBench, MotorThatTurnsBothWaysIsNominalWithoutAFault) {
  for (const unsigned seed : tests::Seeds(1, 7)) {
    const Diagnosis diagnosis =
        Diagnose(BenchOf(kBothWays), Record(kBothWaysRig, kBothWaysRig, seed));
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value())
        << diagnosis.calibration_refusal->message;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_TRUE(diagnosis.episodes.empty());
  }
}

TEST(ReversingBench, ASpeedOfAPulseAgoIsNoFault) {
  std::string text = kBothWays;
  const std::string pulses = "pulses_per_revolution = 250";
  text.replace(text.find(pulses), pulses.size(), "pulses_per_revolution = 2000");
  const std::string noise = "noise = 1.0";
  text.replace(text.find(noise), noise.size(), "noise = 0.2");
  Rig rig = kBothWaysRig;
  rig.speed_step_s = 0.0;
  rig.still_rad_s = 2.0 * std::numbers::pi / (2000.0 * 0.01);
  rig.pulse_rad = 2.0 * std::numbers::pi / 2000.0;
  rig.n_noise = 0.2;
  for (const unsigned seed : tests::Seeds(1, 7)) {
    const Diagnosis diagnosis = Diagnose(BenchOf(text), Record(rig, rig, seed));
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value())
        << diagnosis.calibration_refusal->message;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_TRUE(diagnosis.episodes.empty()) << seed;
  }
  Rig faulty = rig;
  faulty.j = 20e-6;
  ExpectNamed(BenchOf(text), Record(rig, faulty, 9), "J", faulty.j, 0.05);
}

TEST(ReversingBench, CurrentThatLagsBehindAReversalIsNoFault) {
  // La/Ra is most of a period, and the motor often turns around twice in one.
  std::string text = kBothWays;
  for (const auto& [from, to] :
       {std::pair{"La = 0.24e-3", "La = 2.4e-3"},
        std::pair{"symbol = \"J\"", "symbol = \"J\"\nrange = [1e-6, 2e-4]"},
        std::pair{"mc_nm = 2.0e-3", "La = 0.1\nmc_nm = 6.0e-3"},
        std::pair{"friction_noise_nm = 0.2e-3", "friction_noise_nm = 0.1e-3"}}) {
    text.replace(text.find(from), std::string(from).size(), to);
  }
  Rig rig = kBothWaysRig;
  rig.la = 2.5e-3;
  rig.mc = 6.5e-3;
  rig.breakaway_nm = 9e-3;
  rig.friction_noise_nm = 0.1e-3;
  rig.low_v = -2.5;
  rig.high_v = 2.5;
  rig.clock = 7;
  for (const unsigned seed : tests::Seeds(21, 25)) {
    const Diagnosis diagnosis = Diagnose(BenchOf(text), Record(rig, rig, seed));
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value())
        << diagnosis.calibration_refusal->message;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_TRUE(diagnosis.episodes.empty());
  }
  Rig faulty = rig;
  faulty.j = 22e-6;
  ExpectNamed(BenchOf(text), Record(rig, faulty, 25), "J", faulty.j, 0.06);
}

TEST(ReversingBench, FaultsOfAMotorThatTurnsBothWaysAreNamed) {
  Rig faulty = kBothWaysRig;
  faulty.ra = 3.0;
  ExpectNamed(BenchOf(kBothWays), Record(kBothWaysRig, faulty, 7), "Ra", faulty.ra, 0.05);
  faulty = kBothWaysRig;
  faulty.ke = faulty.kt = 19e-3;
  ExpectNamed(BenchOf(kBothWays), Record(kBothWaysRig, faulty, 8), "Ke", faulty.ke, 0.05);
  faulty = kBothWaysRig;
  faulty.j = 20e-6;
  ExpectNamed(BenchOf(kBothWays), Record(kBothWaysRig, faulty, 9), "J", faulty.j, 0.05);
  faulty = kBothWaysRig;
  faulty.k = 3.2;
  ExpectNamed(BenchOf(kBothWays), Record(kBothWaysRig, faulty, 10), "k", faulty.k, 0.05);
}

TEST(ReversingBench, OfAMotorThatHardlyTurnsNoSecondFaultIsSaid) {
  Rig rig = kBothWaysRig;
  rig.low_v = -2.0;
  rig.high_v = 2.0;
  rig.clock = 120;
  rig.breakaway_nm = 4.6e-3;
  Rig faulty = rig;
  faulty.ra = 44.0;  // leaves 4.2 mNm, which breaks away with the help of friction's noise
  const Bench& bench = BenchOf(kBothWays);
  for (const unsigned seed : {31U, 32U}) {
    const std::vector<Sample> record = Record(rig, faulty, seed);
    ExpectNamed(bench, record, "Ra", faulty.ra, 0.06);
    const Diagnosis diagnosis = Diagnose(bench, record);
    EXPECT_EQ(diagnosis.episodes.size(), 1U) << seed;
    EXPECT_NE(diagnosis.verdict.reason.find("hardly turns"), std::string::npos);
  }
}

}  // namespace
}  // namespace faultlab::core
