#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json/parse.hpp>
#include <cmath>
#include <string>
#include <utility>

#include "tests/server/cli/child_program.h"
#include "tests/support/paths.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
const std::string kData = tests::InSource("tests/data");

class CliDiagnose : public ChildProgram {
 protected:
  json::value Answer(const std::string& arguments) const {
    const Finished run = Run("diagnose --json " + arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.exit_code == 0 ? json::parse(run.out) : json::value(json::object());
  }
};

TEST_F(CliDiagnose, NamesComponentValueAndTimeOfASimulatedFault) {
  ASSERT_EQ(Run("simulate --fault R1=100@10 -o run.csv.gz").exit_code, 0);
  const json::value answer = Answer("run.csv.gz");
  EXPECT_EQ(answer.at("file"), "run.csv.gz");
  EXPECT_EQ(answer.at("samples"), 2000);
  EXPECT_EQ(answer.at("period_s"), 0.01);
  EXPECT_EQ(answer.at("verdict"), "fault");
  ASSERT_EQ(answer.at("group").as_array().size(), 1u);
  EXPECT_EQ(answer.at("group").at(0), "R1");
  const json::value& best = answer.at("candidates").at(0);
  EXPECT_EQ(best.at("component"), "R1");
  EXPECT_EQ(best.at("unit"), "ohm");
  EXPECT_NEAR(best.at("value").to_number<double>(), 100.0, 3.0);
  EXPECT_TRUE(best.at("bound").is_null());
  const double detected_at_s = answer.at("detected_at_s").to_number<double>();
  EXPECT_GE(detected_at_s, 10.0);
  EXPECT_LE(detected_at_s, 10.1);
  EXPECT_TRUE(answer.at("calibration").is_object());
  EXPECT_TRUE(answer.at("estimates").at("sia_100_20").at("theta").is_array());
  EXPECT_TRUE(answer.at("fit_percent").at("swa").is_number());
}

TEST_F(CliDiagnose, AnswersForAnIndependentRecordingOfTheBench) {
  const json::value fault = Answer(kData + "/r1_33ohm.csv.gz --healthy 0.5:4");
  EXPECT_EQ(fault.at("verdict"), "fault");
  EXPECT_EQ(fault.at("group").at(0), "R1");
  EXPECT_NEAR(fault.at("candidates").at(0).at("value").to_number<double>(), 33.0, 1.0);
  const json::value healthy = Answer(kData + "/nofault.csv.gz --healthy 0.5:4");
  EXPECT_EQ(healthy.at("verdict"), "nominal");
  EXPECT_TRUE(healthy.at("detected_at_s").is_null());
}

TEST_F(CliDiagnose, TellsHowAHealthyMotorAnswersOfWhichTheSpeedIsAll) {
  ASSERT_EQ(Run("simulate --bench speed-motor --seed 13 --duration 20 -o speed.csv").exit_code, 0);
  const json::value nominal = Answer("--bench speed-motor speed.csv");
  EXPECT_EQ(nominal.at("verdict"), "nominal");
  const json::value& gain = nominal.at("response").at("after").at("gain_rpm_per_v");
  EXPECT_NEAR(
      gain.at("value").to_number<double>(), 58.4, 3.0 * gain.at("sigma").to_number<double>());
  const std::string text = Run("diagnose --bench speed-motor speed.csv").out;
  EXPECT_NE(text.find("\n  response    gain 58."), std::string::npos) << text;
  EXPECT_EQ(text.find("\n  before"), std::string::npos) << text;
}

TEST_F(CliDiagnose, SaysThatAFileIsOfAnotherBenchThanItIsReadAs) {
  ASSERT_EQ(Run("simulate --bench servo-motor --duration 1 -o servo.csv").exit_code, 0);
  ASSERT_EQ(Run("simulate --duration 1 -o paper.csv").exit_code, 0);
  const std::string note =
      "note: servo.csv is of bench servo-motor, it is read as paper: give --bench\n";
  for (const std::string command : {"diagnose", "calibrate -o c.json", "plot -o p.png", "study"}) {
    EXPECT_NE(Run(command + " servo.csv").err.find(note), std::string::npos) << command;
    EXPECT_EQ(Run(command + " paper.csv").err.find("is of bench"), std::string::npos) << command;
  }
  ASSERT_EQ(Run("simulate --bench servo-motor --duration 12 -o long.csv").exit_code, 0);
  const Finished as_it_is = Run("diagnose --bench servo-motor long.csv");
  EXPECT_EQ(as_it_is.exit_code, 0);
  EXPECT_EQ(as_it_is.err.find("is of bench"), std::string::npos) << as_it_is.err;
  ASSERT_EQ(Run("bench new --structure motor-driver -o mine.toml").exit_code, 0);
  ASSERT_EQ(Run("simulate --bench mine.toml --duration 12 -o mine.csv").exit_code, 0);
  std::string text = Read("mine.toml");
  EXPECT_EQ(Run("diagnose --bench mine.toml mine.csv").err, "");
  ASSERT_EQ(Run("simulate --bench mine.toml --duration 1 -o mine.csv").exit_code, 0);
  Write("mine.toml", text.replace(text.find("\nJ = "), 5, "\nJ = 1"));
  const Finished changed = Run("diagnose --bench mine.toml mine.csv");
  EXPECT_NE(changed.err.find("was described otherwise"), std::string::npos) << changed.err;
  const Finished other = Run("diagnose --bench gear-motor servo.csv");
  EXPECT_NE(other.err.find("is of bench servo-motor"), std::string::npos) << other.err;
}

TEST_F(CliDiagnose, PrintsTextForAPerson) {
  const Finished run = Run("diagnose --healthy 0.5:4 " + kData + "/r1_33ohm.csv.gz");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* part : {"r1_33ohm.csv.gz: fault\n",
                           "component",
                           "R1 = 3",
                           "+-",
                           "ohm",
                           "certainty",
                           "over 99.9 %",
                           "runner-up",
                           "path",
                           "calibrated"}) {
    EXPECT_NE(run.out.find(part), std::string::npos) << part << "\n" << run.out;
  }
}

TEST_F(CliDiagnose, AClockThatBeganEarlierChangesNothingButTheTimes) {
  ASSERT_EQ(Run("simulate --fault R1=100@10 -o run.csv").exit_code, 0);
  Run("",
      "awk -F, -v OFS=, '/^#/{next} !h{h=1;print;next} {$1=sprintf(\"%.2f\",$1+40);print}' "
      "run.csv > late.csv;");
  const Finished late = Run("diagnose late.csv");
  EXPECT_NE(late.out.find("component   R1"), std::string::npos) << late.out << late.err;
  EXPECT_NE(late.out.find("at 50.0"), std::string::npos) << late.out;
  EXPECT_EQ(Run("calibrate late.csv -o rig.json").exit_code, 0);
  EXPECT_EQ(Run("plot late.csv --figure sia -o late.png").exit_code, 0);
}

TEST_F(CliDiagnose, GivesEachBadFileItsSentenceAndGoesOnWithTheOthers) {
  std::string two_bases = "t_s,uc_v,um_v\n";
  for (int k = 0; k < 100; ++k) {
    two_bases += std::to_string(k < 60 ? 0.01 * k : 0.59 + 0.02 * (k - 59)) + ",2,5\n";
  }
  const std::pair<std::string, std::string> cases[] = {
      {"t_s,uc_v,ua_v\n0,2,5\n",
       "faultlab: bad.csv:1: column um_v: missing: 't_s' was taken for t_s, 'uc_v' was taken for "
       "uc_v, 'ua_v' was taken for ua_v; expected t_s, uc_v, um_v (or ia_a, or n_rpm, where a "
       "bench is "
       "diagnosed by it) and any of ua_v, ia_a, n_rpm, "
       "separated by commas\n"},
      {"t,Voltage_V,Speed_rad_s\n0,2,5\n0.01,2,6\n",
       "faultlab: note: bad.csv: column 't' was read as t_s\n"
       "faultlab: note: bad.csv: column 'Voltage_V' was read as uc_v\n"
       "faultlab: note: bad.csv: column 'Speed_rad_s' was read as n_rpm\n"
       "faultlab: bad.csv: column um_v: missing: the bench paper is diagnosed by um; with voltage "
       "and speed alone, describe a bench of the structure motor-by-speed (the shipped speed-motor "
       "is one): its gain, its time constant and its friction can be told\n"},
      {"t_s,uc_v,um_v\n0,2,5\n0.01,2,x\n",
       "faultlab: bad.csv:3: column um_v: expected a number, found 'x'\n"},
      {"t_s,uc_v,um_v\n0,2,5\n0.01,NaN,5\n",
       "faultlab: bad.csv:3: column uc_v: expected a number in every row, found 'NaN'; only "
       "measured channels may miss a reading\n"},
      {"t_s,uc_v,um_v\n0,2,5\n0.01,2,5\n0.01,2,5\n",
       "faultlab: bad.csv:4: column t_s: time repeats 0.01 s, expected it to rise by one period in "
       "each row\n"},
      {two_bases,
       "faultlab: bad.csv:62: column t_s: two time bases: the step is 0.02 s from here on, "
       "expected "
       "0.01 s as in most of the file\n"},
      {"",
       "faultlab: bad.csv:1: the file is empty, expected a header line with t_s, uc_v, um_v "
       "(or ia_a, or n_rpm, where a bench is diagnosed by it) and any of ua_v, ia_a, n_rpm, "
       "separated by "
       "commas\n"}};
  for (const auto& [text, message] : cases) {
    Write("bad.csv", text);
    const Finished run = Run("diagnose --json bad.csv " + kData + "/nofault.csv.gz");
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.err, message);
    EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 1) << "the good file is answered";
  }
  const Finished missing = Run("diagnose none.csv");
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_EQ(missing.err, "faultlab: cannot read none.csv: No such file or directory\n");
  Write("cut.csv.gz", "\x1F\x8B\x08");
  EXPECT_EQ(Run("diagnose cut.csv.gz").err,
            "faultlab: cut.csv.gz: damaged or cut gzip data; copy the file again\n");
}

TEST_F(CliDiagnose, RefusesBadOptionsByName) {
  const std::pair<std::string, std::string> cases[] = {
      {"--healthy 5",
       "faultlab: --healthy '5': expected FROM:TO in seconds, 0 <= FROM < TO, for "
       "example 0.5:5\n"},
      {"--healthy 5:1",
       "faultlab: --healthy '5:1': expected FROM:TO in seconds, 0 <= FROM < TO, "
       "for example 0.5:5\n"},
      {"--channels both", "faultlab: --channels 'both': expected um or all\n"},
      {"--values table3", "faultlab: --values 'table3': expected table2 or none\n"}};
  for (const auto& [arguments, message] : cases) {
    const Finished run = Run("diagnose " + arguments + " x.csv");
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_EQ(run.err, message);
  }
}

TEST_F(CliDiagnose, AcceptsWindowsLineEndsLostReadingsAndGaps) {
  ASSERT_EQ(Run("simulate --fault R12=5600@10 -o run.csv").exit_code, 0);
  std::string text = "\xEF\xBB\xBF";
  for (const char letter : Read("run.csv")) {
    text += letter == '\n' ? "\r\n" : std::string(1, letter);
  }
  const std::size_t hole = text.find("\r\n15,") + 2;
  text.erase(hole, text.find("\r\n15.04") + 2 - hole);
  Write("windows.csv", text);
  const Finished run = Run("diagnose --json windows.csv");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("4 rows missing before this line"), std::string::npos) << run.err;
  const json::value answer = json::parse(run.out);
  EXPECT_EQ(answer.at("samples"), 1996);
  EXPECT_EQ(answer.at("verdict"), "fault");
}

TEST_F(CliDiagnose, AnswersForARecordThatIsTooShortOrTooPoor) {
  Write("short.csv", "t_s,uc_v,um_v\n0,2,4.8\n0.01,3,7\n0.02,2,4.8\n");
  const json::value brief = Answer("short.csv");
  EXPECT_NE(brief.at("verdict"), "fault");
  EXPECT_TRUE(brief.at("calibration").is_null());
  std::string flat = "t_s,uc_v,um_v\n";
  for (int k = 0; k < 2000; ++k) {
    flat += std::to_string(0.01 * k) + ",2.5,6\n";
  }
  Write("flat.csv", flat);
  const json::value poor = Answer("flat.csv");
  EXPECT_EQ(poor.at("verdict"), "not_excited") << "a constant input proves nothing";
  EXPECT_EQ(poor.at("calibration_refusal").at("check"), "excitation");
  EXPECT_EQ(poor.at("reason"), poor.at("calibration_refusal").at("message"));
  EXPECT_EQ(poor.at("reason"),
            "not calibrated, check 'excitation' failed: the input switches 0 times, at least 8 are "
            "needed; use an input that switches, such as a PRBS");
  const Finished text = Run("diagnose flat.csv");
  EXPECT_EQ(text.out.rfind("flat.csv: not excited\n", 0), 0u) << text.out;
  EXPECT_EQ(text.out.find("not calibrated"), text.out.rfind("not calibrated")) << "said once";
}

TEST_F(CliDiagnose, DiagnosesARecordWithoutAHealthyStartByAStoredCalibration) {
  ASSERT_EQ(Run("simulate --duration 30 --seed 5 -o healthy.csv").exit_code, 0);
  const Finished learnt = Run("calibrate --healthy 0.5:30 healthy.csv -o rig.json --dated 2026-11");
  ASSERT_EQ(learnt.exit_code, 0) << learnt.err;
  EXPECT_NE(learnt.out.find("healthy.csv: calibrated on 0.50 s to 30.00 s, 2950 samples"),
            std::string::npos)
      << learnt.out;
  const json::value stored = json::parse(Read("rig.json"));
  EXPECT_EQ(stored.at("dated"), "2026-11");
  EXPECT_EQ(stored.at("covariance").as_array().size(), 64u);
  ASSERT_EQ(Run("simulate --fault R12=3300@1 --seed 6 --duration 8 -o early.csv").exit_code, 0);
  const json::value answer = Answer("--calibration rig.json --healthy 0.3:5 early.csv");
  EXPECT_EQ(answer.at("verdict"), "fault");
  EXPECT_NEAR(answer.at("onset_s").to_number<double>(), 1.0, 0.05);
  EXPECT_EQ(answer.at("calibration").at("dated"), "2026-11");
  const json::array& used = answer.at("calibration").at("covariance").as_array();
  const json::array& given = stored.at("covariance").as_array();
  ASSERT_EQ(used.size(), given.size());
  for (std::size_t i = 0; i < used.size(); ++i) {
    const double number = given[i].to_number<double>();
    EXPECT_NEAR(used[i].to_number<double>(), number, 1e-14 * std::abs(number)) << i;
  }
}

TEST_F(CliDiagnose, FitsTheModelsToTenSecondsOfAnyPeriod) {
  ASSERT_EQ(Run("simulate --period 0.02 --excitation prbs:clock=0.04 --duration 20 --fault "
                "R12=3.3k@9.9 -o slow.csv")
                .exit_code,
            0);
  const json::value answer = Answer("slow.csv");
  EXPECT_GT(answer.at("fit_percent").at("isolated").to_number<double>(), 95.0)
      << "the healthy half is no part of it";
}

TEST_F(CliDiagnose, LearnsLongerFromSlowSamples) {
  ASSERT_EQ(Run("simulate --period 0.05 --excitation prbs:clock=0.1 --duration 30 --fault "
                "R1=100@20 -o slow.csv")
                .exit_code,
            0);
  const json::value answer = Answer("slow.csv");
  EXPECT_EQ(answer.at("verdict"), "fault");
  EXPECT_EQ(Run("calibrate slow.csv -o rig.json").exit_code, 0);
}

TEST_F(CliDiagnose, RefusesACalibrationThatIsNoneOrOfAnotherPeriod) {
  ASSERT_EQ(Run("simulate --duration 6 --seed 5 -o healthy.csv").exit_code, 0);
  ASSERT_EQ(Run("calibrate healthy.csv -o rig.json").exit_code, 0);
  ASSERT_EQ(
      Run("simulate --duration 6 --period 0.02 --excitation prbs:clock=0.02 -o slow.csv").exit_code,
      0);
  const Finished slow = Run("diagnose --calibration rig.json slow.csv");
  EXPECT_EQ(slow.exit_code, 2);
  EXPECT_EQ(slow.err,
            "faultlab: slow.csv: the record has a period of 20 ms, the calibration is for 10 ms; "
            "calibrate at the record's period\n");
  std::string text = Read("rig.json");
  text.replace(text.find("\"delta_s\""), 9, "\"delta_x\"");
  Write("cut.json", text);
  EXPECT_EQ(Run("diagnose --calibration cut.json healthy.csv").err,
            "faultlab: cut.json: member delta_s: expected a number\n");
  Write("none.json", "{\"verdict\":1");
  EXPECT_EQ(Run("diagnose --bench gear-motor --calibration rig.json healthy.csv").err,
            "faultlab: rig.json: of a rig of bench 'paper', not of 'gear-motor'; give the file of "
            "that bench as --bench\n");
  EXPECT_EQ(Run("diagnose --calibration none.json healthy.csv").exit_code, 2);
  EXPECT_EQ(Run("diagnose --calibration absent.json healthy.csv").exit_code, 2);
}

TEST_F(CliDiagnose, WritesNoCalibrationOfAStretchThatHoldsAFault) {
  ASSERT_EQ(Run("simulate --duration 10 --fault R12=3300@3 -o broken.csv").exit_code, 0);
  const Finished run = Run("calibrate --healthy 0.5:10 broken.csv -o rig.json");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("broken.csv: not calibrated, check '"), std::string::npos) << run.err;
  EXPECT_NE(Run("diagnose --calibration rig.json broken.csv").exit_code, 0);
}

TEST_F(CliDiagnose, ReadsEveryRecordingOfAFolder) {
  ASSERT_EQ(Run("simulate --duration 6 -o runs_a.csv").exit_code, 0);
  const Finished run = Run("diagnose --json --healthy 0.5:4 " + kData);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 4);
  EXPECT_LT(run.out.find("double.csv.gz"), run.out.find("nofault.csv.gz")) << "by name";
  EXPECT_EQ(Run("diagnose /proc/self/fdinfo").exit_code, 2) << "a folder without recordings";
}

TEST_F(CliDiagnose, SaysSoWhenTheAnswerCannotBeWritten) {
  const Finished run = Run("diagnose " + kData + "/nofault.csv.gz > /dev/full");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.err, "faultlab: cannot write the standard output: No space left on device\n");
}

}  // namespace
}  // namespace faultlab::server
