// The diagnosis of benches other than the paper's: another structure, other scales, 500 Hz, no
// measured voltage; an encoder alone.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/diagnosis/diagnose_record.h"
#include "core/plant/coefficients.h"
#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "core/signals/prbs.h"
#include "hardware/bench/bench_reader.h"
#include "hardware/bench/benches.h"
#include "tests/core/diagnosis/verdicts.h"
#include "tests/support/scale.h"

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
  for (const std::uint64_t seed : tests::Seeds(211, 214)) {
    const Diagnosis diagnosis = DiagnoseRecord(Record({}, seed), OptionsOf(Servo()));
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value())
        << diagnosis.calibration_refusal->message;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_FALSE(diagnosis.calibration->used_um);
  }
}

/// Voltage and speed alone tell a gain, a time constant and the friction: parts that move one of
/// them alike are a group.
/// Its pulses are timed; or counted until shortly after the edge of the row's own input, or until
/// shortly before the next; or there are few of them.
enum class Encoder { kTimed, kCountedEarly, kCountedLate, kCoarse };

const Bench& SpeedBench(Encoder encoder) {
  const Bench& shipped = *hardware::LoadBench("speed-motor").value();
  const auto counted = [&shipped](const std::string& delta_s, const std::string& pulses) {
    std::string text = shipped.text;
    const auto change = [&text](std::string_view from, const std::string& to) {
      text.replace(text.find(from), from.size(), to);
    };
    change("[channel.n]\n", "[channel.n]\ncounted = true\n");
    change("delta_s = 0.009", "delta_s = " + delta_s);
    change("pulses_per_revolution = 44", "pulses_per_revolution = " + pulses);
    return hardware::ReadBench(text, "counted.toml").value();
  };
  static const Bench kEarly = counted("0.0005", "44");
  static const Bench kLate = counted("0.009", "44");
  static const Bench kCoarse = counted("0.0005", "12");
  switch (encoder) {
    case Encoder::kTimed:
      return shipped;
    case Encoder::kCountedEarly:
      return kEarly;
    case Encoder::kCountedLate:
      return kLate;
    case Encoder::kCoarse:
      break;
  }
  return kCoarse;
}

/// 20 s with Ke at 0.8 from 10 s on.
std::vector<Sample> WeakMagnet(const Bench& bench, std::uint64_t seed) {
  const Component magnet = bench.Find("Ke").value();
  const std::vector<Fault> faults = {{magnet, 0.8 * bench.nominal.Get(magnet), 10.0}};
  const std::vector<double> uc = Generate(bench.excitation, 20.0, bench.period_s).value();
  return SimulateRecord(bench.profiles.front(), bench.nominal, uc, faults, seed, bench.period_s);
}

void ExpectWeakMagnet(const Bench& bench, const std::vector<Sample>& record) {
  const Verdict verdict = DiagnoseRecord(record, OptionsOf(bench)).verdict;
  const Component magnet = bench.Find("Ke").value();
  ASSERT_EQ(verdict.kind, VerdictKind::kFault) << verdict.reason;
  EXPECT_NE(std::ranges::find(verdict.group, magnet), verdict.group.end()) << verdict.reason;
  EXPECT_NEAR(*verdict.detected_at_s, 10.0, 0.3);
}

class SpeedMotor : public testing::TestWithParam<Encoder> {
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
  const Bench& bench_ = SpeedBench(GetParam());
};

TEST_P(SpeedMotor, IsNominalWithoutAFault) {
  for (const std::uint64_t seed : tests::Seeds(221, 224)) {
    const Diagnosis diagnosis = Diagnose(nullptr, 1.0, seed);
    ASSERT_FALSE(diagnosis.calibration_refusal.has_value())
        << diagnosis.calibration_refusal->message;
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNominal) << diagnosis.verdict.reason;
    EXPECT_EQ(diagnosis.calibration->mask(), 4U);
    ASSERT_FALSE(diagnosis.fit_percent.empty());
    EXPECT_GT(diagnosis.fit_percent.front().percent, 80.0);
  }
}

TEST_P(SpeedMotor, NamesAGroupThatHoldsTheFault) {
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

TEST(OtherBench, ARecordOfAnotherBenchSaysOfWhich) {
  const Bench& gear = *hardware::LoadBench("gear-motor").value();
  const Bench& paper = hardware::PaperBench();
  const std::vector<double> uc = Generate(gear.excitation, 20.0, gear.period_s).value();
  const std::vector<Sample> record =
      SimulateRecord(gear.profiles.front(), gear.nominal, uc, {}, 271U, gear.period_s);
  const DiagnosisOptions options = OptionsOf(Servo(), gear.period_s);
  Diagnosis diagnosis = DiagnoseRecord(record, options);
  ASSERT_TRUE(diagnosis.calibration_refusal) << diagnosis.verdict.reason;
  const std::vector<const Bench*> others = {&Servo(), &paper, &gear};
  SuggestBench(record, options, others, diagnosis);
  EXPECT_NE(diagnosis.verdict.reason.find("it fits the bench gear-motor: was it measured there?"),
            std::string::npos)
      << diagnosis.verdict.reason;

  Diagnosis alone = DiagnoseRecord(record, options);
  const std::string before = alone.verdict.reason;
  SuggestBench(record, options, std::span(others).first(2), alone);
  EXPECT_EQ(alone.verdict.reason, before) << "none fits";
}

/// Gain and time constant that the sentence about a record of `uc` states, with their errors.
std::vector<double> StatedResponse(const Bench& bench, std::span<const double> uc) {
  const std::vector<Sample> record =
      SimulateRecord(bench.profiles.front(), bench.nominal, uc, {}, 261U, bench.period_s);
  const std::string reason = DiagnoseRecord(record, OptionsOf(bench)).verdict.reason;
  std::vector<double> numbers(4);
  const std::size_t at = reason.find("step response: ");
  EXPECT_NE(at, std::string::npos) << reason;
  if (at == std::string::npos) return numbers;
  double level = 0.0;
  const char* text = reason.c_str() + at;
  const int read = std::sscanf(text,
                               "step response: gain %lf +- %lf rpm/V, time constant %lf +- %lf ms",
                               &numbers[0],
                               &numbers[1],
                               &numbers[2],
                               &numbers[3]);
  if (read == 4) return numbers;
  EXPECT_EQ(std::sscanf(text,
                        "step response: it settles at %lf +- %lf rpm under %lf V, time constant "
                        "%lf +- %lf ms",
                        &numbers[0],
                        &numbers[1],
                        &level,
                        &numbers[2],
                        &numbers[3]),
            5)
      << reason;
  return numbers;
}

TEST_P(SpeedMotor, ARecordOfOneStepTellsGainAndTimeConstant) {
  const ContinuousCoefficients truth = MakeContinuous(bench_.nominal);
  std::vector<double> uc(1000, 2.0);
  std::fill(uc.begin() + 500, uc.end(), 4.0);
  const std::vector<double> two = StatedResponse(bench_, uc);
  EXPECT_NEAR(two[0], truth.b0, std::max(4.0 * two[1], 0.01 * truth.b0));
  EXPECT_NEAR(two[2], 1e3 * truth.a12, std::max(4.0 * two[3], 0.04e3 * truth.a12));

  const std::vector<double> one = StatedResponse(bench_, std::vector<double>(100, 4.0));
  const double settles = 4.0 * truth.b0 - truth.b02 * bench_.profiles.front().friction.mc_nm;
  EXPECT_NEAR(one[0], settles, std::max(4.0 * one[1], 0.01 * settles));
  EXPECT_NEAR(one[2], 1e3 * truth.a12, std::max(4.0 * one[3], 0.04e3 * truth.a12));
}

TEST_P(SpeedMotor, ARecordInWhichNothingMovesHasNoStepResponse) {
  const std::vector<double> nothing(600, 0.0);
  const std::vector<Sample> still =
      SimulateRecord(bench_.profiles.front(), bench_.nominal, nothing, {}, 262U, bench_.period_s);
  std::vector<Sample> stuck = still;
  for (Sample& sample : stuck) {
    sample.uc_v = sample.t_s < 2.0 ? 0.0 : 1.8;
    sample.n_rpm = 1.2396694214876032;  // a counter that was never set to zero
  }
  for (const std::vector<Sample>& record : {still, stuck}) {
    const Diagnosis diagnosis = DiagnoseRecord(record, OptionsOf(bench_));
    EXPECT_EQ(diagnosis.verdict.kind, VerdictKind::kNotExcited);
    EXPECT_EQ(diagnosis.verdict.reason.find("step response"), std::string::npos)
        << diagnosis.verdict.reason;
  }
}

TEST_P(SpeedMotor, SaysItsResponseWithErrorsThatHold) {
  const auto expect = [](const SpeedResponse& found, const PlantParameters& plant, double mc_nm) {
    const ContinuousCoefficients truth = MakeContinuous(plant);
    const std::pair<Measured, double> pairs[] = {{found.gain, truth.b0},
                                                 {found.time_constant, truth.a12},
                                                 {found.friction, truth.b02 * mc_nm}};
    for (const auto& [measured, expected] : pairs) {
      EXPECT_NEAR(measured.value, expected, 4.0 * measured.sigma) << expected;
      EXPECT_LT(measured.sigma, 0.3 * expected);
    }
    EXPECT_LT(found.gain.sigma, 0.04 * truth.b0) << "of what the model lacks";
    EXPECT_LT(found.time_constant.sigma, 0.08 * truth.a12);
  };
  for (const std::uint64_t seed : tests::Seeds(251, 254)) {
    const Diagnosis diagnosis = Diagnose("Ke", 0.8, seed);
    ASSERT_TRUE(diagnosis.verdict.response) << diagnosis.verdict.reason;
    const double mc_nm = bench_.profiles.front().friction.mc_nm;
    expect(diagnosis.verdict.response->before, bench_.nominal, mc_nm);
    PlantParameters faulty = bench_.nominal;
    faulty.Set(bench_.Find("Ke").value(), 0.8 * faulty.ke_v_per_rad_s);
    expect(diagnosis.verdict.response->after, faulty, mc_nm);
  }
  EXPECT_FALSE(DiagnoseRecord(Record({{Servo().Find("J").value(), 1e-5, kFaultAtS}}, 254U),
                              OptionsOf(Servo()))
                   .verdict.response);
}

TEST_P(SpeedMotor, TheEstimatorsGiveItsGainAndItsTimeConstant) {
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

INSTANTIATE_TEST_SUITE_P(Encoders,
                         SpeedMotor,
                         testing::Values(Encoder::kTimed,
                                         Encoder::kCountedEarly,
                                         Encoder::kCountedLate));

/// A row that was lost, and the reading after it, change nothing.
TEST(CountedSpeed, IsReadAcrossLostRows) {
  const Bench& bench = SpeedBench(Encoder::kCountedEarly);
  std::vector<Sample> record = WeakMagnet(bench, 291U);
  for (std::size_t k = 0; k + 1 < record.size(); k += 97) record[k + 1].n_rpm *= 1.5;
  std::erase_if(record, [](const Sample& sample) { return sample.index % 97 == 0; });
  ExpectWeakMagnet(bench, record);
}

TEST(CountedSpeed, OfFewPulsesIsCoarseButTellsAFault) {
  const Bench& bench = SpeedBench(Encoder::kCoarse);
  ExpectWeakMagnet(bench, WeakMagnet(bench, 292U));
}

TEST(CountedSpeed, ThatIsPairedWithTheWrongInputIsSaid) {
  const Bench& early = SpeedBench(Encoder::kCountedEarly);
  const Bench& late = SpeedBench(Encoder::kCountedLate);
  const auto reason = [](const Bench& made, const Bench& read) {
    return DiagnoseRecord(WeakMagnet(made, 293U), OptionsOf(read)).verdict.reason;
  };
  EXPECT_NE(reason(early, late).find("it fits when delta_s is below half a period"),
            std::string::npos)
      << reason(early, late);
  EXPECT_NE(reason(late, early).find("it fits when delta_s is above half a period"),
            std::string::npos)
      << reason(late, early);
}

// The servo with an input that reverses, and its encoder, or a tachometer in its place.
Bench Reversing(bool tachometer) {
  std::string text = Servo().text;
  const auto replace = [&text](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  replace("input_min_v = 0.0", "input_min_v = -5.0");
  replace("prbs:low=1,high=2,clock=0.02", "prbs:low=-2,high=2,clock=0.1");
  if (tachometer) replace("pulses_per_revolution = 250", "timer_hz = 0");
  return hardware::ReadBench(text, "reversing.toml").value();
}

// At rest n is no reading of an encoder; but this motor should turn.
TEST(ReversingMotor, WhoseSpeedIsNotReadIsNotTakenForHealthyNorForAFault) {
  for (const bool tachometer : {false, true}) {
    const Bench bench = Reversing(tachometer);
    EXPECT_EQ(bench.SpeedFloor() == 0.0, tachometer);
    const PrbsSpec prbs{.low_v = -2.0, .high_v = 2.0, .clock_s = 0.1, .seed = 211};
    std::vector<Sample> record = SimulateRecord(bench.profiles.front(),
                                                bench.nominal,
                                                MakePrbs(prbs, 6000, bench.period_s),
                                                {},
                                                211,
                                                bench.period_s);
    const Verdict healthy = DiagnoseRecord(record, OptionsOf(bench)).verdict;
    EXPECT_EQ(healthy.kind, VerdictKind::kNominal) << healthy.reason;
    for (Sample& sample : record) {
      if (sample.t_s >= kFaultAtS) sample.n_rpm = 0.0;
    }
    const Verdict dead = DiagnoseRecord(record, OptionsOf(bench)).verdict;
    SCOPED_TRACE((tachometer ? "tachometer: " : "encoder: ") + dead.reason);
    EXPECT_EQ(dead.kind, VerdictKind::kUnknownFault);
    ASSERT_TRUE(dead.sensor);
    EXPECT_EQ(dead.sensor->channel, "n");
    EXPECT_LT(*dead.detected_at_s, kFaultAtS + 0.5);
  }
}

// Twenty times its resistance: static friction, which the model does not have, decides when the
// motor turns.
TEST(GearMotor, NamesTheWindingOfAMotorThatFrictionHoldsAndNothingOnTopOfIt) {
  const Bench& bench = *hardware::LoadBench("gear-motor").value();
  const Component ra = *bench.Find("Ra");
  for (const std::uint64_t seed : tests::Seeds(1, 5)) {
    PrbsSpec prbs;
    prbs.low_v = 1.3;
    prbs.high_v = 2.8;
    prbs.clock_s = 0.03;
    prbs.seed = seed;
    Fault open;
    open.component = ra;
    open.value = 60.0;
    open.at_s = kFaultAtS;
    const std::vector<Sample> record = SimulateRecord(bench.profiles.front(),
                                                      bench.nominal,
                                                      MakePrbs(prbs, 1600, bench.period_s),
                                                      {&open, 1},
                                                      seed,
                                                      bench.period_s);
    const Verdict verdict = DiagnoseRecord(record, OptionsOf(bench)).verdict;
    SCOPED_TRACE(verdict.reason);
    EXPECT_EQ(verdict.kind, VerdictKind::kFault);
    ASSERT_EQ(verdict.group.size(), 1U);
    EXPECT_EQ(verdict.group.front(), ra);
    EXPECT_NEAR(ValueOf(verdict, ra), 60.0, 6.0);
    EXPECT_NE(verdict.reason.find("the motor hardly turns"), std::string::npos);
  }
}

}  // namespace
}  // namespace faultlab::core
