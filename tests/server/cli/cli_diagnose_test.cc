#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json/parse.hpp>
#include <cmath>
#include <string>
#include <utility>

#include "tests/server/cli/child_program.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
constexpr char kData[] = FAULTLAB_TEST_DATA;

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
  const json::value fault = Answer(std::string(kData) + "/r1_33ohm.csv.gz --healthy 0.5:4");
  EXPECT_EQ(fault.at("verdict"), "fault");
  EXPECT_EQ(fault.at("group").at(0), "R1");
  EXPECT_NEAR(fault.at("candidates").at(0).at("value").to_number<double>(), 33.0, 1.0);
  const json::value healthy = Answer(std::string(kData) + "/nofault.csv.gz --healthy 0.5:4");
  EXPECT_EQ(healthy.at("verdict"), "nominal");
  EXPECT_TRUE(healthy.at("detected_at_s").is_null());
}

TEST_F(CliDiagnose, PrintsTextForAPerson) {
  const Finished run = Run("diagnose --healthy 0.5:4 " + std::string(kData) + "/r1_33ohm.csv.gz");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* part : {"r1_33ohm.csv.gz: fault\n",
                           "component",
                           "R1 = 3",
                           "+-",
                           "ohm",
                           "runner-up",
                           "path",
                           "calibrated"}) {
    EXPECT_NE(run.out.find(part), std::string::npos) << part << "\n" << run.out;
  }
}

TEST_F(CliDiagnose, GivesEachBadFileItsSentenceAndGoesOnWithTheOthers) {
  std::string two_bases = "t_s,uc_v,um_v\n";
  for (int k = 0; k < 100; ++k) {
    two_bases += std::to_string(k < 60 ? 0.01 * k : 0.59 + 0.02 * (k - 59)) + ",2,5\n";
  }
  const std::pair<std::string, std::string> cases[] = {
      {"t_s,uc_v,ia_a\n0,2,5\n",
       "faultlab: bad.csv:1: column um_v: missing from the header 't_s,uc_v,ia_a', expected t_s, "
       "uc_v, um_v (required) and ua_v, ia_a, n_rpm (optional), separated by commas\n"},
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
       "(required) and ua_v, ia_a, n_rpm (optional), separated by commas\n"}};
  for (const auto& [text, message] : cases) {
    Write("bad.csv", text);
    const Finished run = Run("diagnose --json bad.csv " + std::string(kData) + "/nofault.csv.gz");
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
  EXPECT_NE(poor.at("verdict"), "fault");
  EXPECT_NE(poor.at("verdict"), "nominal") << "a constant input proves nothing";
}

TEST_F(CliDiagnose, SaysSoWhenTheAnswerCannotBeWritten) {
  const Finished run = Run("diagnose " + std::string(kData) + "/nofault.csv.gz > /dev/full");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.err, "faultlab: cannot write the standard output: No space left on device\n");
}

}  // namespace
}  // namespace faultlab::server
