// The diagnosis of benches other than the paper's: another structure, other scales, 500 Hz, no
// measured voltage; an encoder alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "core/plant/coefficients.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
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

/// Voltage and speed alone tell a gain, a time constant and the friction: parts that move one of
/// them alike are a group.
class SpeedMotor : public testing::Test {
 protected:
  Diagnosis Diagnose(const char* symbol, double factor, std::uint64_t seed) const {
    std::vector<Fault> faults;
    if (symbol != nullptr) {
      const Component component = bench_.Find(symbol).value();
      faults.push_back({component, factor * bench_.nominal.Get(component), 10.0});
    }
    const std::vector<double> uc = Generate(bench_.excitation, 20.0, bench_.period_s).value();
    return DiagnoseRecord(
        SimulateRecord(bench_.profiles.front(), bench_.nominal, uc, faults, seed, bench_.period_s),
        OptionsOf(bench_));
  }
  const Bench& bench_ = *hardware::LoadBench("speed-motor").value();
};

TEST_F(SpeedMotor, IsNominalWithoutAFault) {
  for (const std::uint64_t seed : {221U, 222U, 223U}) {
    const Diagnosis diagnosis = Diagnose(nullptr, 1.0, seed);
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value())
        << diagnosis.calibration_refusal->message;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_EQ(diagnosis.calibration->mask(), 4U);
    ASSERT_FALSE(diagnosis.fit_percent.empty());
    EXPECT_GT(diagnosis.fit_percent.front().percent, 80.0);
  }
}

TEST_F(SpeedMotor, NamesAGroupThatHoldsTheFault) {
  const std::pair<const char*, double> changes[] = {
      {"Ke", 0.8}, {"k", 0.8}, {"J", 2.0}, {"Ra", 2.0}, {"B", 3.0}};
  for (const auto& [symbol, factor] : changes) {
    const Diagnosis diagnosis = Diagnose(symbol, factor, 231U);
    const Verdict& verdict = diagnosis.verdict;
    ASSERT_EQ(verdict.kind, VerdictKind::kFault) << symbol << ": " << verdict.reason;
    const Component component = bench_.Find(symbol).value();
    EXPECT_NE(std::ranges::find(verdict.group, component), verdict.group.end())
        << symbol << ": " << verdict.reason;
  }
}

TEST_F(SpeedMotor, TheEstimatorsGiveItsGainAndItsTimeConstant) {
  const Diagnosis diagnosis = Diagnose("Ke", 0.8, 241U);
  PlantParameters faulty = bench_.nominal;
  faulty.Set(bench_.Find("Ke").value(), 0.8 * faulty.ke_v_per_rad_s);
  const ContinuousCoefficients expected = MakeContinuous(faulty);
  const Estimate<3>& sia = diagnosis.estimates[static_cast<std::size_t>(EstimatorId::kSia500x20)];
  // Friction takes a constant part of the speed, which a first-order model without an offset counts
  // as gain: the input's mean is 3 V.
  const double gain = expected.b0 - expected.b02 * bench_.norm.mc_nm / 3.0;
  EXPECT_NEAR(sia.theta[0], gain, 0.02 * gain) << "rpm/V";
  EXPECT_NEAR(sia.theta[2], expected.a1, 0.15 * expected.a1) << "s";
}

}  // namespace
}  // namespace faultlab::core
