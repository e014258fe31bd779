// Readings that are not what they seem: held, late, smoothed, at an end, of two signs.
#include "core/calibration/reading_shapes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "core/calibration/calibrate.h"
#include "core/calibration/step_response.h"
#include "core/signals/prbs.h"
#include "core/signals/random.h"
#include "core/types/number_text.h"
#include "hardware/bench/benches.h"
#include "tests/core/bench_records.h"

namespace faultlab::core {
namespace {

using ::testing::HasSubstr;

/// A healthy record of a bench by its id: gear-motor with ia and n, speed-motor with n alone.
std::vector<Sample> HealthyOf(const Bench& bench, std::uint64_t seed) {
  const PrbsSpec spec{.low_v = 2.0, .high_v = 4.0, .clock_s = 0.05};
  std::vector<Sample> record = SimulateRecord(bench.profiles.front(),
                                              bench.nominal,
                                              MakePrbs(spec, 1000, bench.period_s),
                                              {},
                                              seed,
                                              bench.period_s);
  if (bench.structure->estimated == EstimatedChannel::kSpeed) {
    for (Sample& sample : record) sample.ia_a = kAbsent;
  }
  return Between(record, 0.5, 10.0);
}

std::string SaidOf(const Bench& bench, const std::vector<Sample>& record) {
  CalibrationOptions options;
  options.bench = &bench;
  options.data_sheet = bench.nominal;
  options.period_s = bench.period_s;
  const Result<Calibration> calibration = Calibrate(record, options);
  return calibration.ok() ? "calibrated" : calibration.error().message;
}

class ReadingShapes : public testing::TestWithParam<const char*> {
 protected:
  const Bench& bench_ = *hardware::LoadBench(GetParam()).value();
  const bool has_ia_ = bench_.structure->estimated != EstimatedChannel::kSpeed;
};
INSTANTIATE_TEST_SUITE_P(Benches, ReadingShapes, testing::Values("gear-motor", "speed-motor"));

TEST_P(ReadingShapes, AHealthyRecordHasNone) {
  for (const std::uint64_t seed : {3U, 5U, 7U}) {
    EXPECT_EQ(SaidOf(bench_, HealthyOf(bench_, seed)), "calibrated");
  }
}

TEST_P(ReadingShapes, LateByRowsIsSaidWithHowMany) {
  for (const std::size_t rows : {2U, 3U, 5U, 10U}) {
    std::vector<Sample> record = HealthyOf(bench_, 3);
    for (std::size_t k = record.size() - 1; k >= rows; --k) {
      record[k].ia_a = record[k - rows].ia_a;
      record[k].n_rpm = record[k - rows].n_rpm;
    }
    EXPECT_THAT(SaidOf(bench_, record), HasSubstr("moved " + std::to_string(rows) + " rows up"));
  }
}

TEST_P(ReadingShapes, HeldForSeveralRowsIsSaid) {
  for (const int rows : {2, 4, 10}) {
    std::vector<Sample> record = HealthyOf(bench_, 3);
    for (std::size_t k = 0; k < record.size(); ++k) {
      const std::size_t from = k - k % static_cast<std::size_t>(rows);
      record[k].n_rpm = record[from].n_rpm;
    }
    EXPECT_THAT(SaidOf(bench_, record),
                HasSubstr("n reads the same number " + std::to_string(rows) + " rows long"));
  }
}

TEST_P(ReadingShapes, SmoothedIsSaidWithItsMean) {
  for (const double of_new : {0.5, 0.3, 0.2}) {
    std::vector<Sample> record = HealthyOf(bench_, 3);
    double Sample::*const reading = has_ia_ ? &Sample::ia_a : &Sample::n_rpm;
    double held = record.front().*reading;
    for (Sample& sample : record) sample.*reading = held += of_new * (sample.*reading - held);
    EXPECT_THAT(SaidOf(bench_, record),
                HasSubstr(std::string(has_ia_ ? "ia" : "n") + " is smoothed: it follows a mean"))
        << of_new;
  }
}

/// A mean of the last readings, as firmware takes it.
void TakeMean(double Sample::*reading, std::size_t rows, std::vector<Sample>& record) {
  std::vector<double> last;
  for (Sample& sample : record) {
    last.push_back(sample.*reading);
    if (last.size() > rows) last.erase(last.begin());
    sample.*reading =
        std::accumulate(last.begin(), last.end(), 0.0) / static_cast<double>(last.size());
  }
}

TEST_P(ReadingShapes, AMeanOfTheLastReadingsIsSaidWithItsLength) {
  for (const int rows : {5, 8, 20}) {
    std::vector<Sample> record = HealthyOf(bench_, 3);
    TakeMean(has_ia_ ? &Sample::ia_a : &Sample::n_rpm, static_cast<std::size_t>(rows), record);
    const std::string said = SaidOf(bench_, record);
    EXPECT_THAT(said,
                HasSubstr(std::string(has_ia_ ? "ia" : "n") + " is smoothed: it follows a mean"))
        << rows;
    EXPECT_THAT(said, HasSubstr(Format("%.2g ms", 1e3 * bench_.period_s * rows)));
  }
}

TEST(ReadingShapesOfGearMotor, OfAMeanIsSaidWhatItIsOf) {
  const Bench& bench = *hardware::LoadBench("gear-motor").value();
  for (const std::size_t rows : {4U, 8U, 16U}) {
    std::vector<Sample> of_n = HealthyOf(bench, 3);
    TakeMean(&Sample::n_rpm, rows, of_n);
    EXPECT_THAT(SaidOf(bench, of_n), HasSubstr("n is smoothed: it follows a mean")) << rows;
    std::vector<Sample> of_both = of_n;
    TakeMean(&Sample::ia_a, rows, of_both);
    EXPECT_THAT(SaidOf(bench, of_both), HasSubstr("the readings are smoothed: they follow a mean"))
        << rows;
  }
}

TEST(ReadingShapesOfGearMotor, OneChannelThatComesLateIsNotSmoothed) {
  const Bench& bench = *hardware::LoadBench("gear-motor").value();
  for (const std::size_t rows : {2U, 4U}) {
    std::vector<Sample> record = HealthyOf(bench, 3);
    for (std::size_t k = record.size() - 1; k >= rows; --k)
      record[k].n_rpm = record[k - rows].n_rpm;
    EXPECT_THAT(SaidOf(bench, record),
                HasSubstr(Format("it fits when n is moved %d rows up", static_cast<int>(rows))));
  }
}

TEST(ReadingShapesOfGearMotor, AnEndOfTheRangeIsSaid) {
  const Bench& bench = *hardware::LoadBench("gear-motor").value();
  for (const double end_a : {0.25, 0.4}) {
    std::vector<Sample> record = HealthyOf(bench, 3);
    for (Sample& sample : record) sample.ia_a = std::clamp(sample.ia_a, -end_a, end_a);
    EXPECT_THAT(SaidOf(bench, record), HasSubstr("is that the end of its range?")) << end_a;
  }
}

TEST(ReadingShapesOfGearMotor, AMotorWiredTheOtherWayIsSaid) {
  const Bench& bench = *hardware::LoadBench("gear-motor").value();
  std::vector<Sample> record = HealthyOf(bench, 3);
  for (Sample& sample : record) {
    sample.ia_a *= -1.0;
    sample.n_rpm *= -1.0;
  }
  EXPECT_THAT(SaidOf(bench, record), HasSubstr("the other sign of ia and n: is the motor wired"));
}

TEST(ReadingShapesOfGearMotor, ADriverThatTakesAVoltageIsSaid) {
  const Bench& bench = *hardware::LoadBench("gear-motor").value();
  for (const double taken_v : {0.75, 1.2}) {
    std::vector<Sample> record = HealthyOf(bench, 3);
    for (Sample& sample : record) sample.uc_v += taken_v;
    EXPECT_THAT(SaidOf(bench, record),
                HasSubstr(Format("it fits when uc is less by %.2g V", taken_v)));
  }
}

/// A motor with another part, from the beginning on, under levels from `low_v` to `high_v`.
std::vector<Sample> WithAnotherPart(
    const Bench& bench, const char* part, double factor, double low_v, double high_v, int seed) {
  const Component component = *bench.Find(part);
  const std::vector<Fault> faults = {
      AbruptFault(component, factor * bench.nominal.Get(component), 0.0)};
  std::vector<Sample> record = SimulateRecord(
      bench.profiles.front(),
      bench.nominal,
      MakePrbs({.low_v = low_v, .high_v = high_v, .clock_s = 0.1}, 1500, bench.period_s),
      faults,
      static_cast<std::uint64_t>(seed),
      bench.period_s);
  if (bench.structure->estimated == EstimatedChannel::kSpeed) {
    for (Sample& sample : record) sample.ia_a = kAbsent;
  }
  return Between(record, 0.5, 15.0);
}

TEST_P(ReadingShapes, AnotherPartIsNothingOfTheRecord) {
  for (const int seed : {1, 2, 3}) {
    for (const auto& [part, factor, low_v] :
         {std::tuple{"Ke", 0.6, 2.0}, {"Ke", 0.55, 2.0}, {"k", 0.7, 0.0}, {"k", 1.5, 0.0}}) {
      const std::string said =
          SaidOf(bench_, WithAnotherPart(bench_, part, factor, low_v, 4.0, seed));
      for (const char* wrong :
           {"moved", "uc is less by", "multiplied by 1000", "smoothed", "without n"}) {
        EXPECT_THAT(said, testing::Not(HasSubstr(wrong)))
            << part << " x " << factor << ", " << seed;
      }
    }
  }
}

TEST_P(ReadingShapes, PulsesASecondAreSaid) {
  const double a_turn = bench_.pulses_per_revolution * bench_.nominal.gear_ratio;
  std::vector<Sample> record = HealthyOf(bench_, 3);
  for (Sample& sample : record) sample.n_rpm *= a_turn / 60.0;
  EXPECT_THAT(SaidOf(bench_, record), HasSubstr("is it in pulses a second?"));
}

TEST_P(ReadingShapes, WhatIsSteadyIsNoEndOfARange) {
  Random random(9);
  std::vector<Sample> record = SimulateRecord(
      bench_.profiles.front(),
      bench_.nominal,
      [] {
        std::vector<double> uc_v;
        for (int k = 0; k < 1500; ++k) uc_v.push_back(k / 100 % 2 == 0 ? 2.0 : 4.0);
        return uc_v;
      }(),
      {},
      3,
      bench_.period_s);
  for (Sample& sample : record) {
    sample.ia_a = has_ia_ ? 0.01 * std::round(100.0 * sample.ia_a) : kAbsent;
    sample.n_rpm = std::round(sample.n_rpm);
  }
  EXPECT_EQ(SaidOf(bench_, Between(record, 0.5, 15.0)), "calibrated") << "a slow square";
  std::vector<Sample> step;
  for (int k = 0; k < 500; ++k) {
    Sample sample;
    sample.index = k;
    sample.t_s = 0.01 * k;
    sample.uc_v = k < 50 ? 0.0 : 3.0;
    const double settles = k < 50 ? 0.0 : 163.0 * (1.0 - std::exp(-(k - 50) / 7.0));
    sample.n_rpm = 0.01 * std::round(100.0 * settles);
    step.push_back(sample);
  }
  EXPECT_THAT(SaidOf(bench_, step), testing::Not(HasSubstr("'range'"))) << "a step test";
  for (Sample& sample : step) {
    sample.uc_v = 0.0;
    sample.n_rpm = 0.0;
    sample.ia_a = has_ia_ ? 0.0 : kAbsent;
  }
  EXPECT_THAT(SaidOf(bench_, step), testing::Not(HasSubstr("smoothed"))) << "before the step";
}

TEST_P(ReadingShapes, AQuietRecordWithAnotherDelayOrPeriodIsNotSmoothed) {
  for (const double period_s : {0.005, 0.01}) {
    for (const std::uint64_t seed : {3U, 4U}) {
      BenchProfile quiet = bench_.profiles.front();
      quiet.delta_s = 0.5 * period_s;
      quiet.noise.um_v *= 0.05;
      quiet.noise.ia_a *= 0.05;
      quiet.noise.n_rpm *= 0.05;
      const PrbsSpec spec{.low_v = 2.0, .high_v = 4.0, .clock_s = 0.05};
      std::vector<Sample> record =
          SimulateRecord(quiet, bench_.nominal, MakePrbs(spec, 1500, period_s), {}, seed, period_s);
      for (Sample& sample : record) {
        if (!has_ia_) sample.ia_a = kAbsent;
      }
      CalibrationOptions options;
      options.bench = &bench_;
      options.data_sheet = bench_.nominal;
      options.period_s = period_s;
      const auto calibration = Calibrate(Between(record, 0.5, 1500 * period_s), options);
      if (calibration.ok()) continue;
      EXPECT_THAT(calibration.error().message, testing::Not(HasSubstr("is smoothed"))) << period_s;
    }
  }
}

TEST(HeldRows, AreTheRowsOfASlowBusAndNotOfACounter) {
  Random random(5);
  std::vector<double> own;
  std::vector<double> counted;
  std::vector<double> held;
  for (int k = 0; k < 600; ++k) {
    own.push_back(random.Normal());
    counted.push_back(std::round(0.7 * random.Normal() + std::sin(0.02 * k)));
    held.push_back(k % 6 == 0 ? random.Normal() : held.back());
  }
  EXPECT_EQ(HeldRows(own), 1);
  EXPECT_EQ(HeldRows(counted), 1);
  EXPECT_EQ(HeldRows(held), 6);
  EXPECT_EQ(HeldRows(std::vector<double>(600, 1.0)), 1) << "a motor that stands still";
  EXPECT_EQ(HeldRows(std::span(held).first(40)), 1) << "too few to tell";
}

TEST(StepResponse, IsOfAMotorThatTurnsAndAnswers) {
  const Bench& bench = *hardware::LoadBench("speed-motor").value();
  Random random(1);
  const auto record_of = [&](const std::function<double(double, double)>& uc, double friction_rpm) {
    std::vector<Sample> record;
    double n = 0.0;
    for (int k = 0; k < 2000; ++k) {
      Sample sample;
      sample.index = k;
      sample.t_s = 0.01 * k;
      sample.uc_v = uc(sample.t_s, n);
      const double settles = std::max(0.0, 58.0 * sample.uc_v - friction_rpm);
      const double way = 58.0 * sample.uc_v - friction_rpm - n;
      n = std::max(0.0, n + way * (1.0 - std::exp(-0.01 / 0.07)));
      if (settles == 0.0 && n < 0.5) n = 0.0;
      sample.n_rpm = n + 0.3 * random.Normal();
      record.push_back(sample);
    }
    return record;
  };
  const auto coast = record_of([](double t, double) { return t < 10.0 ? 4.0 : 0.0; }, 15.0);
  const auto text = StepResponseText(coast, bench, 0.01);
  ASSERT_TRUE(text);
  EXPECT_THAT(*text, HasSubstr("gain 58"));
  double sum = 0.0;
  const auto held = record_of(
      [&](double, double n) {
        sum += 0.01 * (130.0 - n);
        return std::clamp(0.012 * (130.0 - n) + 0.15 * sum, 0.0, 5.0);
      },
      15.0);
  const auto of_held = StepResponseText(held, bench, 0.01);
  if (of_held) {
    EXPECT_THAT(*of_held, HasSubstr("gain 5")) << "no gain, or the motor's";
  }
}

TEST(StepResponse, OfACoarseCounterTellsWhereItSettles) {
  const Bench& bench = *hardware::LoadBench("speed-motor").value();
  Random random(2);
  std::vector<Sample> record;
  for (int k = 0; k < 2000; ++k) {
    Sample sample;
    sample.index = k;
    sample.t_s = 0.01 * k;
    sample.uc_v = k < 1000 ? 0.0 : 4.0;
    const double n = k < 1000 ? 0.0 : 232.0 * (1.0 - std::exp(-(k - 999) / 1.5));
    sample.n_rpm = 30.0 * std::floor(n / 30.0 + (k < 1000 ? 0.0 : random.Uniform(0.0, 1.0)));
    record.push_back(sample);
  }
  const auto text = StepResponseText(record, bench, 0.01);
  ASSERT_TRUE(text);
  EXPECT_THAT(*text, HasSubstr("it settles at 23")) << *text;
  EXPECT_THAT(*text, HasSubstr("too few rows, or too coarse, for a time constant")) << *text;
  for (Sample& sample : record) sample.n_rpm = sample.uc_v > 0.0 ? 200.0 * random.Normal() : 0.0;
  EXPECT_FALSE(StepResponseText(record, bench, 0.01)) << "no speed that is steady";
  for (Sample& sample : record) {
    const double falls = sample.index < 1500 ? 165.0 : 150.0;
    sample.n_rpm = sample.uc_v > 0.0 ? falls + 10.0 * random.Normal() : 0.0;
  }
  EXPECT_FALSE(StepResponseText(record, bench, 0.01)) << "where it never was";
  for (Sample& sample : record) {
    sample.uc_v = 3.0;
    sample.n_rpm = 165.0 + 3.0 * random.Normal();
  }
  EXPECT_FALSE(StepResponseText(record, bench, 0.01)) << "it has no beginning";
  record.front().n_rpm = 0.0;
  const auto begun = StepResponseText(record, bench, 0.01);
  ASSERT_TRUE(begun) << "a log that begins with its command";
  EXPECT_THAT(*begun, HasSubstr("it settles at 16")) << *begun;
}

}  // namespace
}  // namespace faultlab::core
