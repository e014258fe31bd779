#include "core/plant/simulate_record.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "core/plant/converters.h"
#include "core/signals/prbs.h"
#include "tests/paper_bench.h"
#include "tests/support/paths.h"

namespace faultlab::core {
namespace {

constexpr int kSamples = 2000;

std::vector<Sample> Load(const std::string& name) {
  std::ifstream file(tests::InSource("tests/data/bench_simulation/" + name + ".csv"));
  std::string line;
  std::getline(file, line);
  std::vector<Sample> record;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    char comma = 0;
    Sample s;
    fields >> s.t_s >> comma >> s.uc_v >> comma >> s.um_v >> comma >> s.ia_a >> comma >> s.n_rpm;
    record.push_back(s);
  }
  return record;
}

struct Case {
  const char* file;
  Component component;
  double value;
  bool multisim;
};

class IndependentSimulator : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Recordings,
                         IndependentSimulator,
                         testing::Values(Case{"r1_33", paper::kR1, 33.0, false},
                                         Case{"c8_2u2", paper::kC8, 2.2e-6, false},
                                         Case{"j_1e-5", paper::kJ, 1.43e-5, false},
                                         Case{"b_5e-5", paper::kB, 5e-5, false},
                                         Case{"b_9e-5_multisim", paper::kB, 9e-5, true}),
                         [](const auto& one) {
                           std::string name = one.param.file;
                           std::erase(name, '-');
                           return name;
                         });

// The same input for both simulators. The differences are two independent noises on each channel
// and, on the bench, two independent friction torques.
TEST_P(IndependentSimulator, SameInputGivesTheSameRecordUpToBothNoises) {
  const std::vector<Sample> theirs = Load(GetParam().file);
  ASSERT_EQ(theirs.size(), static_cast<std::size_t>(kSamples));
  std::vector<double> uc_v;
  for (const Sample& sample : theirs) {
    uc_v.push_back(sample.uc_v);
  }
  const BenchProfile profile = GetParam().multisim ? paper::CircuitSimulation() : paper::Hardware();
  // The other simulator's fault acts from the sample after 10 s.
  const Fault fault{.component = GetParam().component, .value = GetParam().value, .at_s = 10.01};
  const std::vector<Sample> ours =
      SimulateRecord(profile, paper::Plant(), uc_v, std::span(&fault, 1), 1, paper::kPeriodS);

  for (const auto& [begin, end] : {std::pair(100, 1000), std::pair(1100, kSamples)}) {
    double um = 0.0;
    double ia = 0.0;
    double n = 0.0;
    for (int k = begin; k < end; ++k) {
      const Sample& a = ours[static_cast<std::size_t>(k)];
      const Sample& b = theirs[static_cast<std::size_t>(k)];
      um += (a.um_v - b.um_v) * (a.um_v - b.um_v) / (end - begin);
      ia += (a.ia_a - b.ia_a) * (a.ia_a - b.ia_a) / (end - begin);
      n += (a.n_rpm - b.n_rpm) * (a.n_rpm - b.n_rpm) / (end - begin);
    }
    // Friction torques differ by sqrt(2) 0.02 mNm: through b02 on um, 1/KT on ia, b02/R1/Ke.. on n.
    const PlantParameters nominal = paper::Plant();
    const double r1 = begin > 1000 && fault.component == paper::kR1 ? fault.value : 1.0;
    const double torque = std::sqrt(2.0) * profile.friction.noise_rms_nm;
    const double friction_ia = torque / nominal.kt_nm_per_a;
    const double friction_n =
        GearRpm(friction_ia * (nominal.ra_ohm + r1) / nominal.ke_v_per_rad_s, paper::kGearRatio);
    const auto expected = [](double noise, double friction) {
      return std::sqrt(2.0 * noise * noise + friction * friction);
    };
    // The other simulator's amplifier has finite gain, and its speed has no timer: allowances of 2
    // mV, 0.3 mA, 0.4 rpm.
    EXPECT_LT(std::sqrt(um), 1.15 * expected(profile.noise.um_v, r1 * friction_ia) + 2e-3);
    EXPECT_LT(std::sqrt(ia), 1.15 * expected(profile.noise.ia_a, friction_ia) + 0.3e-3);
    EXPECT_LT(std::sqrt(n), 1.15 * expected(profile.noise.n_rpm, friction_n) + 0.4);
    EXPECT_GT(std::sqrt(um), 0.9 * std::sqrt(2.0) * profile.noise.um_v);
  }
}

TEST(SimulateRecord, SameArgumentsGiveTheSameBitsAndOtherSeedsOtherNoise) {
  const std::vector<double> uc_v = MakePrbs({}, 300, 0.01);
  const Fault fault{.component = paper::kJ, .value = 1e-5, .at_s = 1.0};
  const auto record = [&](std::uint64_t seed) {
    return SimulateRecord(
        paper::Hardware(), paper::Plant(), uc_v, std::span(&fault, 1), seed, paper::kPeriodS);
  };
  const std::vector<Sample> a = record(1);
  const std::vector<Sample> b = record(1);
  const std::vector<Sample> c = record(2);
  int equal = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].um_v, b[k].um_v);
    EXPECT_EQ(a[k].ua_v, b[k].ua_v);
    EXPECT_EQ(a[k].ia_a, b[k].ia_a);
    EXPECT_EQ(a[k].n_rpm, b[k].n_rpm);
    equal += a[k].um_v == c[k].um_v;
  }
  EXPECT_LT(equal, 20);  // codes of 0.3 mV under 15 mV of noise are sometimes equal
}

TEST(SimulateRecord, FaultActsFromTheFirstSampleAtOrAfterItsTime) {
  BenchProfile quiet = paper::CircuitSimulation();
  quiet.noise = {};
  const std::vector<double> uc_v(100, 3.0);
  const Fault fault{.component = paper::kR9, .value = 33e3, .at_s = 0.5};
  const auto record =
      SimulateRecord(quiet, paper::Plant(), uc_v, std::span(&fault, 1), 1, paper::kPeriodS);
  EXPECT_GT(record[49].um_v, 7.0);
  EXPECT_LT(record[50].um_v, 5.0);
  EXPECT_EQ(record[50].index, 50);
  EXPECT_DOUBLE_EQ(record[50].t_s, 0.5);
}

TEST(SimulateRecord, StartsFromRestAndClipsAtTheConvertersRail) {
  BenchProfile quiet = paper::CircuitSimulation();
  quiet.noise = {};
  const std::vector<double> uc_v(100, 5.0);  // 12 V at the motor, 10 V at the converter
  const auto record = SimulateRecord(quiet, paper::Plant(), uc_v, {}, 1, paper::kPeriodS);
  EXPECT_LT(record[0].n_rpm, 300.0);
  EXPECT_DOUBLE_EQ(record[99].um_v, 10.0 - 2.0 * 10.0 / kConverterSteps);
  EXPECT_GT(record[99].n_rpm, 1100.0);
}

}  // namespace
}  // namespace faultlab::core
