#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <string>

#include "tests/server/cli/child_program.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class CliMethods : public ChildProgram {};

TEST_F(CliMethods, ComparesMethodsOnSimulatedRuns) {
  const Finished run =
      Run("methods --method rls-reset --method parity --trials 1 --hours 0.05 --json "
          "--markdown table.md --plots figures");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  ASSERT_EQ(answer.at("methods").as_array().size(), 2U);
  const json::value& rls = answer.at("methods").at(0);
  EXPECT_EQ(rls.at("method"), "rls-reset");
  EXPECT_EQ(rls.at("of"), 18);
  EXPECT_GE(rls.at("detected").as_int64(), 15);
  EXPECT_EQ(rls.at("faults").as_array().size(), 18U);
  EXPECT_EQ(answer.at("methods").at(1).at("error_median_percent"), nullptr)
      << "parity sizes nothing";
  const auto& records = answer.at("records").as_array();
  ASSERT_EQ(records.size(), 2U * 18U);
  EXPECT_EQ(records.at(0).at("method"), "rls-reset");
  EXPECT_EQ(records.at(0).at("fault").at("component"), "R1");
  EXPECT_EQ(records.at(0).at("component"), "R1");
  EXPECT_NEAR(records.at(0).at("value").to_number<double>(), 10.0, 1.0);
  EXPECT_GE(records.at(0).at("detected_at_s").to_number<double>(),
            records.at(0).at("fault").at("at_s").to_number<double>());
  EXPECT_EQ(records.at(1).at("value"), nullptr);
  EXPECT_EQ(records.at(1).at("cannot"), (json::array{"identify"}));
  EXPECT_NE(Read("table.md").find("| Parity equations (`parity`) |"), std::string::npos);
  EXPECT_NE(Read("table.md").find("cannot"), std::string::npos);
  EXPECT_EQ(Read("figures/methods.png").substr(1, 3), "PNG");
}

TEST_F(CliMethods, MeasuresByAllChannelsBehindTheTableByUm) {
  ASSERT_EQ(Run("simulate --fault R1=56@10 -o records/a.csv", "mkdir records;").exit_code, 0);
  const std::string common = "methods --method signal --recordings records --markdown table.md ";
  ASSERT_EQ(Run(common + "--channels um").exit_code, 0);
  const Finished run = Run(common + "--channels all --append --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.err, "") << "progress is for terminals";
  const json::value answer = json::parse(run.out);
  EXPECT_EQ(answer.at("channels"), "all");
  EXPECT_NE(answer.at("methods").at(0).at("level"), 104.282) << "two channels, another level";
  const std::string table = Read("table.md");
  EXPECT_EQ(table.find("# The methods"), 0U);
  EXPECT_EQ(table.find("# The methods", 1), std::string::npos) << "one title";
  EXPECT_LT(table.find("channels um: 1 given"), table.find("channels all: 1 given"));
  const Finished wrong = Run("methods --channels speed");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_EQ(wrong.err.find("faultlab: --channels 'speed'"), 0U) << wrong.err;
}

TEST_F(CliMethods, TakesRecordingsWithTheirFaults) {
  ASSERT_EQ(Run("simulate --fault R1=56@10 -o records/a.csv", "mkdir records;").exit_code, 0);
  ASSERT_EQ(Run("simulate --seed 7 -o records/b.csv").exit_code, 0);
  const Finished run = Run("methods --method ga --recordings records --json --plots figures");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  const json::value& ga = answer.at("methods").at(0);
  EXPECT_EQ(answer.at("recordings"), 2);
  EXPECT_EQ(ga.at("of"), 1);
  EXPECT_EQ(ga.at("isolated"), 1);
  EXPECT_EQ(answer.at("records").at(0).at("file"), "a.csv");
  EXPECT_EQ(answer.at("records").at(1).at("fault"), nullptr);
  EXPECT_EQ(ga.at("false_alarms"), 0);
  ASSERT_EQ(ga.at("faults").as_array().size(), 1U);
  EXPECT_EQ(ga.at("faults").at(0).at("isolated"), 1);
  EXPECT_EQ(Read("figures/methods.png").substr(1, 3), "PNG");
  const Finished healthy =
      Run("methods --method ls --recordings records --plots figures", "rm records/a.csv;");
  EXPECT_EQ(healthy.err,
            "faultlab: --plots draws methods and faults; none of these recordings names its "
            "fault\n");
}

TEST_F(CliMethods, LeavesOutRecordingsWithTwoFaultsOrOneThatTheBenchCannotHave) {
  const std::string make = "for i in a b c d; do cp run.csv records/$i.csv; done; ";
  ASSERT_EQ(Run("simulate --duration 12 -o run.csv", "mkdir records;").exit_code, 0);
  Write("records/manifest.json",
        R"({"recordings": [
          {"file": "a.csv", "faults": [{"component": "Mc", "value": 0.0007, "at_s": 10}]},
          {"file": "b.csv", "faults": [{"component": "R1", "value": 10, "at_s": 10}]},
          {"file": "c.csv", "faults": [{"component": "R1", "value": 10, "at_s": 10},
                                       {"component": "J", "value": 1e-6, "at_s": 10}]},
          {"file": "d.csv", "faults": []}]})");
  const Finished run = Run("methods --method ls --recordings records --json", make);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  ASSERT_EQ(answer.at("records").as_array().size(), 2U);
  EXPECT_EQ(answer.at("records").at(0).at("file"), "b.csv");
  EXPECT_EQ(answer.at("records").at(1).at("file"), "d.csv");
}

TEST_F(CliMethods, DiagnosesByAMethodOfChoice) {
  ASSERT_EQ(Run("simulate --fault R12=2000@10 -o run.csv").exit_code, 0);
  const Finished text = Run("diagnose run.csv --method rls-reset");
  ASSERT_EQ(text.exit_code, 0) << text.err;
  EXPECT_EQ(text.out.find("run.csv: rls-reset: alarm at 10.0"), 0U) << text.out;
  const Finished run = Run("diagnose run.csv --method parity --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  EXPECT_NEAR(answer.at("detected_at_s").to_number<double>(), 10.0, 0.5);
  const json::value& last = answer.at("looks").as_array().back();
  EXPECT_EQ(last.at("isolation"), "given");
  EXPECT_EQ(last.at("identification"), "cannot");
  EXPECT_EQ(last.at("answer").at(0).at("value"), nullptr);
}

TEST_F(CliMethods, RefusesWhatItDoesNotHaveByName) {
  const Finished unknown = Run("methods --method magic");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_EQ(unknown.err.find("faultlab: --method 'magic': expected one of ls rls"), 0U)
      << unknown.err;
  ASSERT_EQ(Run("bench new --structure motor-driver -o other.toml").exit_code, 0);
  ASSERT_EQ(Run("simulate --bench other.toml --duration 6 -o run.csv").exit_code, 0);
  const Finished other = Run("diagnose --bench other.toml run.csv --method nn");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.err.find("--method 'nn' was made for another bench"), std::string::npos)
      << other.err;
  EXPECT_EQ(Run("methods --recordings nowhere").exit_code, 2);
}

TEST_F(CliMethods, RunsOnAnotherBench) {
  ASSERT_EQ(Run("bench new --structure motor-driver -o other.toml").exit_code, 0);
  const Finished run = Run("methods --bench other.toml --method ls --trials 1 --hours 0 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  EXPECT_GT(answer.at("methods").at(0).at("detected").as_int64(), 0);
}

}  // namespace
}  // namespace faultlab::server
