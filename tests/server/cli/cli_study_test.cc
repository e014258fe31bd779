#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <string>
#include <utility>

#include "tests/server/cli/child_program.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

class CliStudy : public ChildProgram {};

TEST_F(CliStudy, ShowsThatALongWindowSpreadsLessAndSettlesLater) {
  ASSERT_EQ(Run("simulate --fault R1=10@10 -o run.csv").exit_code, 0);
  const Finished run = Run("study run.csv --k 25,200 --km \"\" --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  EXPECT_EQ(answer.at("change_s"), 10.0) << "from the record's own comment";
  const json::value& brief = answer.at("variants").at(0);
  const json::value& lengthy = answer.at("variants").at(1);
  EXPECT_EQ(brief.at("name"), "swa_25");
  EXPECT_EQ(lengthy.at("window"), 200);
  const auto spread = [](const json::value& variant) {
    return variant.at("parameters").at(1).at("before").at("sd").to_number<double>();
  };
  EXPECT_LT(2.0 * spread(lengthy), spread(brief));
  EXPECT_GT(lengthy.at("settling_s").to_number<double>(),
            brief.at("settling_s").to_number<double>());
}

TEST_F(CliStudy, DrawsBothFamiliesAndPrintsATable) {
  ASSERT_EQ(Run("simulate --fault R1=10@10 -o run.csv").exit_code, 0);
  const Finished run = Run("study run.csv --km 100:5,100:20 --exact --plots figures");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* part :
       {"change at 10 s", "swa_200", "sia_100_5_exact", "settles", "b0d", "a1"}) {
    EXPECT_NE(run.out.find(part), std::string::npos) << part << "\n" << run.out;
  }
  EXPECT_EQ(Read("figures/swa.png").substr(1, 3), "PNG");
  EXPECT_EQ(Read("figures/sia.png").substr(1, 3), "PNG");
}

TEST_F(CliStudy, RefusesWindowsThatCannotBeByName) {
  ASSERT_EQ(Run("simulate --duration 6 -o run.csv").exit_code, 0);
  const std::pair<std::string, std::string> cases[] = {
      {"--k 50,x", "faultlab: --k '50,x': expected windows K such as 50,100,200\n"},
      {"--km 20", "faultlab: --km '20': expected pairs K:m such as 20:5,100:20\n"},
      {"--change soon", "faultlab: --change 'soon': expected auto, none or a time in seconds\n"},
      {"--k 3 --km \"\"", "faultlab: run.csv: the window K must be 6 to 100000 samples\n"},
      {"--k 5000 --km \"\"",
       "faultlab: run.csv: swa_5000 needs more samples on each side of the change.\n"},
      {"--order 2 --plots p",
       "faultlab: --plots draws b0, b1, a1 of order 1 without a constant; leave out --order and "
       "--affine\n"}};
  for (const auto& [arguments, message] : cases) {
    const Finished run = Run("study run.csv " + arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_EQ(run.err, message);
  }
}

}  // namespace
}  // namespace faultlab::server
