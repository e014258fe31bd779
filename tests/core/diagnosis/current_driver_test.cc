// A motor whose amplifier drives a current: simulated as one (Plant holds the current where the
// supply lets it), diagnosed by the models of a voltage source behind a large resistance.
#include <gtest/gtest.h>

#include <string>

#include "core/diagnosis/diagnose_record.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation_text.h"
#include "hardware/bench/benches.h"
#include "tests/core/bench_records.h"
#include "tests/core/diagnosis/verdicts.h"

namespace faultlab::core {
namespace {

constexpr double kFaultS = 10.0;

const Bench& PaperCurrent() {
  return *hardware::LoadBench("paper-current").value();
}

std::vector<Sample> RecordOf(const std::string& excitation,
                             const std::vector<Fault>& faults,
                             std::uint64_t seed) {
  const Bench& bench = PaperCurrent();
  const auto uc_v =
      Generate(ParseExcitation(excitation, seed).value(), 2.0 * kFaultS, bench.period_s).value();
  return SimulateRecord(bench.profiles.front(), bench.nominal, uc_v, faults, seed, bench.period_s);
}

Diagnosis Diagnosed(const std::vector<Fault>& faults, std::uint64_t seed) {
  const Bench& bench = PaperCurrent();
  DiagnosisOptions options = OptionsOf(bench, bench.period_s);
  options.um_rail_v = bench.um.max;
  return DiagnoseRecord(RecordOf(bench.excitation_text, faults, seed), options);
}

TEST(CurrentDriver, HealthyOneIsLearntAndWatchedInPeace) {
  for (std::uint64_t seed = 1; seed < 9; ++seed) {
    const Diagnosis diagnosis = Diagnosed({}, seed);
    ASSERT_TRUE(diagnosis.calibration) << diagnosis.calibration_refusal->message;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    for (const CalibratedQuantity& each : diagnosis.calibration->quantities) {
      if (each.name != "k") continue;
      EXPECT_EQ(each.unit, "A/V");
      EXPECT_NEAR(each.value, 0.2, 0.002);
    }
  }
}

TEST(CurrentDriver, EachOfItsFaultsIsNamedWithItsValue) {
  std::uint64_t seed = 100;
  for (const Component component : PaperCurrent().components()) {
    for (const double value : component.info().offered) {
      const Verdict verdict = Diagnosed({AbruptFault(component, value, kFaultS)}, ++seed).verdict;
      SCOPED_TRACE(std::string(Name(component)) + " = " + std::to_string(value) + ": " +
                   verdict.reason);
      EXPECT_EQ(verdict.kind, VerdictKind::kFault);
      ASSERT_TRUE(Names(verdict, component));
      EXPECT_EQ(verdict.group.size(), 1U);
      EXPECT_NEAR(ValueOf(verdict, component), value, 0.05 * value);
      EXPECT_NEAR(verdict.detected_at_s.value_or(0.0), kFaultS, 1.0);
    }
  }
}

// One step shows J for a second or two; what follows shows neither the fault nor a healthy rig.
TEST(CurrentDriver, AFaultThatTheInputShowsNoLongerStays) {
  const Bench& bench = PaperCurrent();
  const Component j = *bench.Find("J");
  const double value = 2.0 * bench.nominal.Get(j);
  DiagnosisOptions options = OptionsOf(bench, bench.period_s);
  options.um_rail_v = bench.um.max;
  for (std::uint64_t seed = 1; seed < 6; ++seed) {
    options.calibration = Diagnosed({}, seed).calibration;
    ASSERT_TRUE(options.calibration);
    const Verdict verdict =
        DiagnoseRecord(
            RecordOf("step:low=0.1,high=0.16,at=12", {AbruptFault(j, value, kFaultS)}, 100 + seed),
            options)
            .verdict;
    EXPECT_EQ(verdict.kind, VerdictKind::kFault) << verdict.reason;
    EXPECT_TRUE(Names(verdict, j)) << verdict.reason;
    EXPECT_NEAR(ValueOf(verdict, j), value, 0.15 * value);
  }
}

}  // namespace
}  // namespace faultlab::core
