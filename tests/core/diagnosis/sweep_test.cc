// Records whose input is a sweep, an excitation that the page offers: the healthy stretch has low
// frequencies alone.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/diagnosis/diagnose_record.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "hardware/bench/benches.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/support/scale.h"

namespace faultlab::core {
namespace {

constexpr ChirpSpec kSweep{.offset_v = 2.4, .amplitude_v = 0.8, .from_hz = 0.2, .to_hz = 8.0};

// Every part within 3 % of the data sheet.
PlantParameters SomeRig(const Bench& bench, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> off(0.97, 1.03);
  PlantParameters rig = bench.nominal;
  for (std::size_t k = 0; k < rig.structure->parameters.size(); ++k) {
    rig.Set(static_cast<int>(k), rig.Get(static_cast<int>(k)) * off(random));
  }
  rig.kt_nm_per_a = rig.ke_v_per_rad_s;
  return rig;
}

Diagnosis Diagnosed(const Bench& bench, const std::vector<Fault>& faults, unsigned seed) {
  const auto samples = static_cast<int>(std::lround(20.0 / bench.period_s));
  const std::vector<double> uc_v = MakeChirp(kSweep, samples, bench.period_s);
  return DiagnoseRecord(
      SimulateRecord(
          bench.profiles.front(), SomeRig(bench, seed), uc_v, faults, seed, bench.period_s),
      OptionsOf(bench));
}

TEST(Sweep, FindsAHealthyRigHealthyWhoseHigherFrequenciesWereNotLearnt) {
  for (const unsigned seed : tests::Seeds(1, 13)) {
    const Diagnosis diagnosis = Diagnosed(paper::Bench(), {}, seed);
    EXPECT_FALSE(diagnosis.calibration_refusal.has_value()) << seed;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal)
        << seed << ": " << diagnosis.verdict.reason;
  }
}

TEST(Sweep, NamesAFaultOfEachBench) {
  for (const char* name : {"paper", "servo-motor", "gear-motor"}) {
    SCOPED_TRACE(name);
    const Bench& bench = *hardware::LoadBench(name).value();
    const Component ra = *bench.Find("Ra");
    const double value = 2.0 * bench.nominal.ra_ohm;
    const Diagnosis diagnosis = Diagnosed(bench, {AbruptFault(ra, value)}, 21);
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value())
        << diagnosis.calibration_refusal->message;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kFault) << diagnosis.verdict.reason;
    ASSERT_EQ(diagnosis.verdict.group.size(), 1U) << diagnosis.verdict.reason;
    EXPECT_TRUE(Names(diagnosis.verdict, ra));
    EXPECT_NEAR(ValueOf(diagnosis.verdict, ra), value, 0.05 * value);
  }
}

}  // namespace
}  // namespace faultlab::core
