#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json/parse.hpp>
#include <string>

#include "tests/server/cli/child_program.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using ::testing::HasSubstr;

class CliControl : public ChildProgram {};

TEST_F(CliControl, SaysHowWellTheSpeedWasKept) {
  const Finished run = Run("control --fault R1=100@10 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  EXPECT_EQ(answer.at("accommodated"), true);
  EXPECT_GT(answer.at("compensated_at_s").to_number<double>(), 10.0);
  EXPECT_LT(answer.at("compensated_at_s").to_number<double>(), 11.0);
  const json::value without =
      json::parse(Run("control --fault R1=100@10 --controller nominal --json").out);
  EXPECT_EQ(without.at("compensated_at_s"), nullptr);
  EXPECT_LT(2.0 * answer.at("iae").to_number<double>(), without.at("iae").to_number<double>());
}

TEST_F(CliControl, RefusesWhatTheRigCannotReach) {
  const Finished run = Run("control --fault R12=2k@10");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("refused       the rig reaches 149"));
  EXPECT_THAT(Run("control --reference 100:2000").err, HasSubstr("the healthy rig reaches"));
  EXPECT_THAT(Run("control --reference fast").err, HasSubstr("expected LOW:HIGH in rad/s"));
  EXPECT_THAT(Run("control --controller pid").err, HasSubstr("expected nominal, compensated or"));
  EXPECT_EQ(Run("control --duration 2").exit_code, 2);
}

TEST_F(CliControl, SaysWhereARealRigWouldHaveEnded) {
  const std::string hot = "control --fault B=180u@10 --controller nominal";
  const json::value answer = json::parse(Run(hot + " --json").out);
  EXPECT_EQ(answer.at("trip"), "over_heat");
  EXPECT_NEAR(answer.at("trip_at_s").to_number<double>(), 16.0, 1.0);
  EXPECT_THAT(Run(hot).out, HasSubstr("s: over_heat. A real rig ends its run there"));
  const json::value cool = json::parse(Run("control --fault R1=10@10 --json").out);
  EXPECT_EQ(cool.at("trip"), nullptr);
}

TEST_F(CliControl, WritesTheTableOfAllFaults) {
  const Finished run = Run("control --duration 16 --markdown control.md");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string table = Read("control.md");
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 6 + 19) << table;
  EXPECT_THAT(table, HasSubstr("| R12=2000@10 |"));
}

}  // namespace
}  // namespace faultlab::server
