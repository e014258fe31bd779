#include "hardware/run_forecast.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/plant/simulate_record.h"
#include "core/signals/excitation.h"
#include "hardware/bench/bench_reader.h"
#include "hardware/bench/benches.h"

namespace faultlab::hardware {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<double> UsualInput(const core::Bench& bench) {
  return core::Generate(bench.excitation, 20.0, bench.period_s).value();
}

/// The description of the servo motor with `from` replaced by `to`.
core::Bench Servo(const std::string& from, const std::string& to) {
  std::string text = LoadBench("servo-motor").value()->text;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return ReadBench(text.replace(at, from.size(), to), "mine.toml").value();
}

std::vector<std::string> SentencesOf(const RunForecast& forecast) {
  std::vector<std::string> sentences;
  for (const RunProblem& problem : forecast.problems) sentences.push_back(problem.text);
  return sentences;
}

std::vector<std::string> ProblemsOf(const core::Bench& bench) {
  return SentencesOf(ForecastRun(bench, UsualInput(bench)));
}

TEST(RunForecast, FindsNothingWrongWithTheShippedBenches) {
  for (const char* name : {"paper", "servo-motor", "gear-motor", "paper-current"}) {
    EXPECT_THAT(ProblemsOf(*LoadBench(name).value()), IsEmpty()) << name;
  }
}

TEST(RunForecast, SaysThatTheInputLeavesItsRange) {
  EXPECT_THAT(ProblemsOf(Servo("input_max_v = 5.0", "input_max_v = 1.5")),
              ElementsAre("uc goes from 1 to 2 V, the bench takes 0 to 1.5 V"));
}

TEST(RunForecast, SaysThatTheInputLeavesItsConverter) {
  EXPECT_THAT(ProblemsOf(Servo("[channel.ia]", "[channel.uc]\nv_per_unit = 8.0\n[channel.ia]")),
              ElementsAre("uc goes from 1 to 2 V, its converter at +-10 V writes -1.25 to 1.25 V"));
}

TEST(RunForecast, SaysThatTheSupplyIsTooLow) {
  EXPECT_THAT(ProblemsOf(Servo("output_max_v = 24.0", "output_max_v = 7.5")),
              ElementsAre("output goes from 4 to 8 V, the supply gives -24 to 7.5 V"));
}

TEST(RunForecast, SaysWhichConverterIsTooNarrow) {
  EXPECT_THAT(ProblemsOf(Servo("[channel.n]\nnoise = 1.0", "[channel.n]\nrange = [0, 2500]")),
              ElementsAre(HasSubstr("rpm, its range is 1.25 to 2499 rpm")));
  const core::Bench volts = Servo("[channel.n]", "[channel.um]\nrange = [-6, 6]\n[channel.n]");
  EXPECT_THAT(ProblemsOf(volts),
              ElementsAre("um goes from 4 to 8 V, its converter reads -5.994 to 5.994 V"));
}

TEST(RunForecast, SaysThatTheInputIsTooSteep) {
  EXPECT_THAT(
      ProblemsOf(Servo("slew_v_per_s = 2000.0", "slew_v_per_s = 500.0")),
      ElementsAre("uc steps by 2 V within a period of 2 ms, limits.slew_v_per_s = 500 allows "
                  "1 V"));
}

TEST(RunForecast, SaysWhichInterlockEndsTheRunAndWhen) {
  const std::vector<std::string> said =
      ProblemsOf(Servo("current_continuous_a = 2.2", "current_continuous_a = 0.2"));
  ASSERT_EQ(said.size(), 1U);
  EXPECT_THAT(said.front(), HasSubstr("the interlock over_heat ends the run after "));
  EXPECT_THAT(said.front(), HasSubstr("thermal mean of the current 0.2"));
}

TEST(RunForecast, JudgesARigWithAFault) {
  const core::Bench& bench = *LoadBench("servo-motor").value();
  const core::Fault short_circuit{.component = bench.Find("Ra").value(), .value = 0.3};
  EXPECT_THAT(SentencesOf(ForecastRun(bench, UsualInput(bench), short_circuit)),
              ElementsAre(HasSubstr("ia goes from"), HasSubstr("over_current")));
}

TEST(RunForecast, GivesTheFiguresOfARecordWithoutEnds) {
  const core::Bench& bench = *LoadBench("gear-motor").value();
  const std::vector<double> uc = UsualInput(bench);
  core::BenchProfile quiet = bench.profiles.front();
  quiet.noise = {};
  quiet.friction.noise_rms_nm = 0.0;
  SignalSpan current;
  for (const core::Sample& sample :
       core::SimulateRecord(quiet, bench.nominal, uc, {}, 1, bench.period_s)) {
    current.Include(sample.ia_a);
  }
  const RunForecast forecast = ForecastRun(bench, uc);
  const SignalForecast& ia = forecast.signals.at(5);
  ASSERT_EQ(ia.name, "ia");
  const double step = 10.0 / 65536.0;
  EXPECT_NEAR(ia.reaches.max, current.max, 2.0 * step);
  EXPECT_NEAR(ia.reaches.min, current.min, 2.0 * step);
}

}  // namespace
}  // namespace faultlab::hardware
