#include "hardware/bench/bench_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "hardware/bench/benches.h"
#include "tests/paper_bench.h"

namespace faultlab::hardware {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// The shipped description with `from` replaced by `to`.
std::string Changed(std::string_view shipped, const std::string& from, const std::string& to) {
  std::string text(shipped);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string RefusalOf(std::string_view shipped, const std::string& from, const std::string& to) {
  const auto bench = ReadBench(Changed(shipped, from, to), "mine.toml");
  return bench.ok() ? "accepted" : bench.error().message;
}

TEST(BenchReader, GivesThePapersBenchAsPrinted) {
  const core::Bench& bench = PaperBench();
  EXPECT_EQ(bench.name, "paper");
  EXPECT_EQ(bench.component_count(), 8);
  EXPECT_DOUBLE_EQ(bench.nominal.gain(), 2.4);
  EXPECT_EQ(bench.component(2).info().order, core::SwitchOrder::kMakeBeforeBreak);
  EXPECT_EQ(bench.profiles.size(), 2U);
  EXPECT_DOUBLE_EQ(bench.um.max, 10.0);
}

TEST(BenchReader, ACountedSpeedIsMeasuredButNotEstimatedFrom) {
  const auto counted = ReadBench(
      Changed(PaperBench().text, "[channel.n]\n", "[channel.n]\ncounted = true\n"), "mine.toml");
  ASSERT_TRUE(counted.ok()) << counted.error().message;
  EXPECT_TRUE(counted.value().n.exists);
  EXPECT_FALSE(counted.value().readings().has_n);
  EXPECT_TRUE(PaperBench().readings().has_n);
}

TEST(BenchReader, ACountedSpeedAloneIsTheMeanOfAPeriodAndItsNoiseThatOfTheCounting) {
  const core::Bench& timed = *LoadBench("speed-motor").value();
  const auto counted =
      ReadBench(Changed(timed.text, "[channel.n]\n", "[channel.n]\ncounted = true\n"), "mine.toml");
  ASSERT_TRUE(counted.ok()) << counted.error().message;
  const core::Bench& bench = counted.value();
  EXPECT_TRUE(bench.readings().has_n);
  EXPECT_FALSE(bench.readings().of_row_before) << "read 1 ms before the next edge";
  EXPECT_NEAR(bench.ReadingDelay(bench.delta_s, bench.period_s), 0.004, 1e-12);
  EXPECT_EQ(bench.n.step_s, 0.0);
  const double pulse_rpm = 60.0 / (44 * 34 * 0.01);
  EXPECT_NEAR(bench.n.noise, pulse_rpm / std::sqrt(6.0), 1e-9);

  const auto early = ReadBench(Changed(bench.text, "delta_s = 0.009", "delta_s = 0.001"), "a.toml");
  ASSERT_TRUE(early.ok()) << early.error().message;
  EXPECT_TRUE(early.value().readings().of_row_before);
  EXPECT_NEAR(early.value().ReadingDelay(0.001, 0.01), 0.006, 1e-12);
  EXPECT_FALSE(timed.readings().of_row_before);
  EXPECT_EQ(timed.ReadingDelay(0.009, 0.01), 0.009);
}

TEST(BenchReader, GivesABenchOfTheOtherStructure) {
  const auto kept = LoadBench("servo-motor");
  ASSERT_TRUE(kept.ok()) << kept.error().message;
  const core::Bench& bench = *kept.value();
  EXPECT_FALSE(bench.um.exists);
  EXPECT_TRUE(bench.ia.exists);
  EXPECT_EQ(bench.structure->estimated, core::EstimatedChannel::kIa);
  const core::Component magnet = bench.Find("Ke").value();
  core::PlantParameters plant = bench.nominal;
  plant.Set(magnet, 0.5 * plant.Get(magnet));
  EXPECT_DOUBLE_EQ(plant.kt_nm_per_a, plant.ke_v_per_rad_s) << "a weaker magnet lowers both";
}

TEST(BenchReader, KeepsOneBenchForOneText) {
  EXPECT_EQ(KeepBench(PaperBench().text, "again").value(), &PaperBench());
  EXPECT_EQ(PaperBench().Find("R1"), paper::kR1);
}

TEST(BenchReader, KnowsABenchByWhatItsTextSays) {
  const std::string& text = PaperBench().text;
  const std::string named = "[bench]\nname = \"paper\"\n";
  EXPECT_EQ(KeepBench("# mended\n" + text + "\n\n# the end", "mine.toml").value(), &PaperBench());
  EXPECT_EQ(KeepBench(Changed(text, named, "[bench] # ours\nname   = \"paper\"\n"), "x").value(),
            &PaperBench());
  const std::string& servo = LoadBench("servo-motor").value()->text;
  EXPECT_EQ(KeepBench(Changed(servo, "k = 4.0", "k = 4"), "x").value(),
            LoadBench("servo-motor").value());
  EXPECT_NE(ReadBench(Changed(text, "J = ", "J = 1"), "x").value().id, PaperBench().id);
}

TEST(BenchReader, RefusesWithFileLineKeyAndWhatWasExpected) {
  EXPECT_THAT(RefusalOf(PaperBench().text, "period_s = 0.01", "period_s = 0.5"),
              StartsWith("mine.toml:8: bench.period_s must be a number from 0.001 to 0.1"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "delta_s = 0.0095 ", "delta_s = 0.011 "),
              HasSubstr("bench.delta_s must lie inside the period"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "structure = \"inverting", "structure = \"unknown"),
              HasSubstr("must be one of inverting-amplifier, motor-driver"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "Ra = 7.41\n", ""),
              HasSubstr("plant.Ra is missing: armature resistance, ohm"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "lines = [19, 18, 3, 2]", "lines = [19, 18, 3, 17]"),
              HasSubstr("uses line 17, which is in use already"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "lines = [19, 18, 3, 2]", "lines = [19, 18, 3]"),
              HasSubstr("one line for each value"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "symbol = \"Ra\"", "symbol = \"Rx\""),
              HasSubstr("component.symbol must be a parameter of the structure: R1, Ra, La"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "symbol = \"Ra\"", "symbol = \"R1\""),
              HasSubstr("stands twice"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "[channel.ua]", "[channel.ux]"),
              HasSubstr("is not a key of this table"));
  EXPECT_THAT(RefusalOf(LoadBench("servo-motor").value()->text, "[channel.ia]", "[channel.um]"),
              HasSubstr("must have ia"));
  EXPECT_THAT(
      RefusalOf(
          LoadBench("servo-motor").value()->text, "and_with_it = \"KT\"", "and_with_it = \"k\""),
      HasSubstr("must be another parameter of the motor"));
}

TEST(BenchReader, RefusesAnExcitationThatCannotBePlayed) {
  const std::string_view paper = PaperBench().text;
  const std::string usual = "\"prbs:low=2,high=3\"";
  for (const auto& [excitation, what] :
       {std::pair{"\"prbs:clock=1e-9\"", "clock_s: The clock of the PRBS"},
        {"\"prbs:low=3,high=3\"", "high_v: The high level"},
        {"\"prbs:order=99\"", "order: The order of the PRBS must be"},
        {"\"step:at=30\"", "at_s: The step must be"},
        {"\"chirp:to=60\"", "to_hz: The last frequency"},
        {"\"prbs:volts=3\"", "'volts=3' is not NAME=NUMBER"},
        {"\"noise\"", "expected prbs, step"}}) {
    const std::string said = RefusalOf(paper, usual, excitation);
    EXPECT_THAT(said, StartsWith("mine.toml:10: bench.excitation ")) << excitation;
    EXPECT_THAT(said, HasSubstr(what)) << excitation;
  }
}

TEST(BenchReader, GivesASlowBenchAnExcitationThatItCanPlay) {
  const std::string servo = LoadBench("servo-motor").value()->text;
  const std::string said = "excitation = \"prbs:low=1,high=2,clock=0.02\"\n";
  const std::string silent = Changed(servo, said, "");
  EXPECT_EQ(ReadBench(silent, "mine.toml").value().excitation_text, "prbs");
  const std::string slow = Changed(silent, "period_s = 0.002", "period_s = 0.01234");
  EXPECT_EQ(ReadBench(slow, "mine.toml").value().excitation_text, "prbs:clock=0.01234");
}

TEST(BenchReader, GivesEachParameterToOneComponent) {
  const std::string servo = LoadBench("servo-motor").value()->text;
  EXPECT_THAT(RefusalOf(servo, "symbol = \"J\"", "symbol = \"disc\"\nchanges = \"Ra\""),
              HasSubstr("component.changes is Ra, which the component Ra changes already"));
  EXPECT_THAT(RefusalOf(servo, "symbol = \"J\"", "symbol = \"KT\""),
              HasSubstr("component.symbol is KT, which the component Ke changes already"))
      << "Ke takes it with it";
  EXPECT_THAT(RefusalOf(servo, "symbol = \"B\"", "symbol = \"B\"\nand_with_it = \"Ra\""),
              HasSubstr("component.and_with_it is Ra, which the component Ra changes already"));
}

TEST(BenchReader, RefusesSymbolsThatCannotBeTyped) {
  const std::string servo = LoadBench("servo-motor").value()->text;
  for (const char* symbol :
       {"R 1", "R=1", "R@1", "R,1", "R\\n1", "1R", "_R", "R\u00e9", "R-1", "R/1"}) {
    const std::string to = std::string("symbol = \"") + symbol + "\"\nchanges = \"J\"";
    EXPECT_THAT(RefusalOf(servo, "symbol = \"J\"", to),
                HasSubstr("component.symbol must be of A-Z, a-z, 0-9 and _"))
        << symbol;
  }
  for (const char* symbol : {"Rotor_2", "x", "Sixteen_letters_"}) {
    const std::string to = std::string("symbol = \"") + symbol + "\"\nchanges = \"J\"";
    EXPECT_EQ(RefusalOf(servo, "symbol = \"J\"", to), "accepted") << symbol;
  }
}

TEST(BenchReader, BoundsTheValuesOfFaults) {
  const std::string servo = LoadBench("servo-motor").value()->text;
  const std::string offered = "offered = [1.16, 3.0, 4.64, 23.2]";
  EXPECT_THAT(
      RefusalOf(servo, offered, "offered = [1.16, 2e3]"),
      HasSubstr("component.offered must lie inside `range`, where a diagnosis looks: 2000 is "
                "outside 0.05 to 1000"));
  EXPECT_THAT(RefusalOf(servo, offered, "offered = [1.16, 1.16]"), HasSubstr("holds 1.16 twice"));
  EXPECT_THAT(RefusalOf(servo, offered, "offered = [2.32]"), HasSubstr("is no fault"));
  std::string many = "offered = [3.0";
  for (int i = 1; i < 3000; ++i) many += ", " + std::to_string(3.0 + 0.01 * i);
  EXPECT_THAT(RefusalOf(servo, offered, many + "]"), HasSubstr("must be at most 32 values"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "published = [10.0,", "published = [1e6,"),
              HasSubstr("component.published must lie inside `range`"));
  EXPECT_THAT(RefusalOf(PaperBench().text, "values = [1.0, 10.0,", "values = [1.0, 5e3,"),
              HasSubstr("component.values must lie inside `range`"));
  EXPECT_THAT(RefusalOf(servo, "range = [0.05, 1e3]", "range = [5.0, 1e3]"),
              HasSubstr("component.range must have the nominal value 2.32 of [plant] inside"));
}

TEST(BenchReader, SeesUnitsOfADataSheet) {
  const std::string servo = LoadBench("servo-motor").value()->text;
  EXPECT_THAT(RefusalOf(servo, "J = 11.0e-6", "J = 110.0"),  // g cm^2
              HasSubstr("plant.J gives the motor a time constant of 4.56e+05 s"));
  EXPECT_THAT(RefusalOf(servo, "Ke = 23.4e-3", "Ke = 2.45"),  // V per 1000 rpm
              HasSubstr("plant.KT is 0.00955 of Ke"));
  EXPECT_THAT(RefusalOf(servo, "La = 0.238e-3", "La = 238.0"),  // uH
              HasSubstr("plant.La gives the winding a time constant of 103 s"));
}

TEST(BenchReader, ScalesOfWhatIsDividedOrShuntedMayBeOffAndThatOfACountMayNot) {
  const core::Bench& gear = *LoadBench("gear-motor").value();
  EXPECT_EQ(gear.ia.gain_sd, 0.005);
  EXPECT_EQ(gear.n.gain_sd, 0.0);
  const auto said = ReadBench(
      Changed(gear.text, "[channel.n]\n", "[channel.n]\ngain_sd = 0.01  # a tachometer\n"),
      "a.toml");
  ASSERT_TRUE(said.ok()) << said.error().message;
  EXPECT_EQ(said.value().n.gain_sd, 0.01);
  EXPECT_THAT(RefusalOf(gear.text, "[channel.n]\n", "[channel.n]\ngain_sd = 2.0\n"),
              HasSubstr("channel.n.gain_sd must be"));
}

TEST(BenchReader, TheShapeOfASimulatorsFrictionIsAWordOfTheDescription) {
  const core::Bench& gear = *LoadBench("gear-motor").value();
  EXPECT_EQ(gear.profiles.front().friction.stribeck_shape, 2) << "Gauss where nothing is said";
  const char* kBefore = "ms_nm = 1.1e-3\n";
  const auto said = ReadBench(
      Changed(gear.text,
              kBefore,
              "ms_nm = 1.1e-3\nfriction_shape = \"tustin\"\nstribeck_speed_rad_s = 8.0\n"),
      "a.toml");
  ASSERT_TRUE(said.ok()) << said.error().message;
  const core::FrictionModel& friction = said.value().profiles.front().friction;
  EXPECT_EQ(friction.stribeck_shape, 1);
  EXPECT_NEAR(friction.StribeckTorque(8.0), (1.1e-3 - friction.mc_nm) * std::exp(-1.0), 1e-9);
  EXPECT_THAT(RefusalOf(gear.text, kBefore, "ms_nm = 1.1e-3\nfriction_shape = \"cubic\"\n"),
              HasSubstr("friction_shape must be"));
}

TEST(BenchReader, NamesNoLineOfWhatTheFileDoesNotHave) {
  EXPECT_THAT(RefusalOf(PaperBench().text, "[bench]", "[bunch]"),
              StartsWith("mine.toml: bench.name must be of a-z"));
  EXPECT_THAT(RefusalOf("[bench]\n", "[bench]", "\n[bench]\nname = \"x\""),
              StartsWith("mine.toml:2: bench.structure is missing"));
  const std::string no_component =
      "[bench]\nname = \"x\"\nstructure = \"motor-driver\"\n"
      "[plant]\nRa = 1.0\nLa = 1e-3\nKe = 0.02\nKT = 0.02\nJ = 1e-5\nB = 1e-6\nk = 1.0\n"
      "[channel.ia]\nnoise = 1e-3\n";
  EXPECT_THAT(RefusalOf(no_component, "\"x\"", "\"y\""),
              StartsWith("mine.toml: component must stand 1 to 16 times"));
}

TEST(BenchReader, ReadsWhatWasPublished) {
  const core::Publication& published = PaperBench().published;
  EXPECT_EQ(published.source, "doi:10.3390/app15158322");
  ASSERT_EQ(published.faults.size(), 18U);
  const core::PublishedFault* fault = published.Find("R1", 10.0);
  ASSERT_NE(fault, nullptr);
  EXPECT_THAT(fault->swa, testing::ElementsAre(1.421, -0.82, -0.738));
  EXPECT_THAT(fault->tables, testing::ElementsAre(3, 7, 11));
  EXPECT_EQ(published.Find("R1", 11.0), nullptr);
  EXPECT_TRUE(LoadBench("servo-motor").value()->published.source.empty());
  const std::string_view paper = PaperBench().text;
  EXPECT_THAT(
      RefusalOf(paper, "{ component = \"R1\", value = 10.0", "{ component = \"R1\", value = 11.0"),
      HasSubstr("published.fault.value must be one of `published` of the component R1"));
  EXPECT_THAT(
      RefusalOf(paper, "{ component = \"R1\", value = 56.0", "{ component = \"R1\", value = 10.0"),
      HasSubstr("published.fault.value stands twice"));
  EXPECT_THAT(RefusalOf(paper, "swa = [1.421, -0.82, -0.738]", "swa = [1.421, -0.82]"),
              HasSubstr("published.fault.swa must be three numbers"));
  EXPECT_THAT(
      RefusalOf(paper, "{ component = \"R1\", value = 10.0", "{ component = \"Rx\", value = 10.0"),
      HasSubstr("published.fault.component must be the symbol of a [[component]]"));
  EXPECT_THAT(RefusalOf(paper, "source = \"doi:10.3390/app15158322\"", "source = \"\""),
              HasSubstr("published.source must name the publication"));
}

TEST(BenchReader, TakesTheSupplyForSimulatorsThatSayNothingElse) {
  const std::string servo = LoadBench("servo-motor").value()->text;
  const std::string bare = servo.substr(0, servo.find("[[simulator]]"));
  const core::Bench bench = ReadBench(bare, "mine.toml").value();
  EXPECT_EQ(bench.profiles.front().amplifier.output_max_v, 24.0);
  EXPECT_EQ(bench.profiles.front().amplifier.quadrants, core::Quadrants::kFour);
  const core::Bench one_sided =
      ReadBench(Changed(bare, "output_min_v = -24.0", "output_min_v = 0.0"), "mine.toml").value();
  EXPECT_EQ(one_sided.profiles.front().amplifier.quadrants, core::Quadrants::kTwo);
}

TEST(BenchReader, KeepsTheRangeOfTheSpeed) {
  const core::Bench bench = ReadBench(Changed(LoadBench("servo-motor").value()->text,
                                              "pulses_per_revolution = 250",
                                              "pulses_per_revolution = 250\nrange = [-100, 3e3]"),
                                      "mine.toml")
                                .value();
  EXPECT_EQ(bench.n.min, -100.0);
  EXPECT_EQ(bench.n.max, 3000.0);
}

TEST(BenchReader, RefusesAnInterlockThatItsChannelCannotReach) {
  const std::string servo = LoadBench("servo-motor").value()->text;
  EXPECT_THAT(RefusalOf(servo, "current_peak_a = 9.5", "current_peak_a = 10.0"),
              HasSubstr("limits.current_peak_a must lie inside the range of [channel.ia]"));
  EXPECT_THAT(RefusalOf(servo, "current_continuous_a = 2.2", "current_continuous_a = 9.6"),
              HasSubstr("limits.current_continuous_a must not be above current_peak_a"));
}

}  // namespace
}  // namespace faultlab::hardware
