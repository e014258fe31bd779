// The diagnosis of a bench other than the paper's: another structure, other scales, 500 Hz, and no
// measured voltage.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "core/plant/simulate_record.h"
#include "core/signals/prbs.h"
#include "hardware/bench/benches.h"
#include "tests/core/diagnosis/verdicts.h"

namespace faultlab::core {
namespace {

constexpr double kFaultAtS = 8.0;
constexpr double kDurationS = 12.0;

const Bench& Servo() {
  static const Bench& bench = *hardware::LoadBench("servo-motor").value();
  return bench;
}

std::vector<Sample> Record(const std::vector<Fault>& faults, std::uint64_t seed) {
  const Bench& bench = Servo();
  PrbsSpec prbs;
  prbs.low_v = 1.0;
  prbs.high_v = 2.0;
  prbs.clock_s = 0.02;
  prbs.seed = seed;
  const auto samples = static_cast<int>(std::lround(kDurationS / bench.period_s));
  return SimulateRecord(bench.profiles.front(),
                        bench.nominal,
                        MakePrbs(prbs, samples, bench.period_s),
                        faults,
                        seed,
                        bench.period_s);
}

struct Case {
  const char* symbol;
  double factor;
};

class ServoMotor : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(SingleFaults,
                         ServoMotor,
                         testing::Values(Case{"Ra", 1.3},
                                         Case{"Ra", 4.0},
                                         Case{"Ke", 0.8},
                                         Case{"J", 2.0},
                                         Case{"J", 0.5},
                                         Case{"B", 3.0},
                                         Case{"k", 0.8}),
                         [](const auto& test) {
                           return std::string(test.param.symbol) + "_" +
                                  std::to_string(std::lround(100.0 * test.param.factor));
                         });

TEST_P(ServoMotor, NamesTheComponentAndItsValueWithinAPercent) {
  const Bench& bench = Servo();
  const Component component = bench.Find(GetParam().symbol).value();
  const double value = GetParam().factor * bench.nominal.Get(component);
  for (const std::uint64_t seed : {201U, 202U}) {
    const Fault fault{component, value, kFaultAtS};
    const Diagnosis diagnosis = DiagnoseRecord(Record({fault}, seed), OptionsOf(bench));
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value())
        << diagnosis.calibration_refusal->message;
    const Verdict& verdict = diagnosis.verdict;
    ASSERT_EQ(verdict.kind, VerdictKind::kFault) << verdict.reason;
    EXPECT_EQ(verdict.group, std::vector<Component>{component}) << verdict.reason;
    const double allowed = component == bench.Find("B") ? 0.05 : 0.02;
    EXPECT_NEAR(ValueOf(verdict, component), value, allowed * value) << verdict.reason;
  }
}

TEST(ServoMotor, IsNominalWithoutAFault) {
  for (const std::uint64_t seed : {211U, 212U, 213U}) {
    const Diagnosis diagnosis = DiagnoseRecord(Record({}, seed), OptionsOf(Servo()));
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value())
        << diagnosis.calibration_refusal->message;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_FALSE(diagnosis.calibration->used_um);
  }
}

}  // namespace
}  // namespace faultlab::core
