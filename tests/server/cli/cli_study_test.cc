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

TEST_F(CliStudy, SaysWhichOrderIsWorthItsParameters) {
  ASSERT_EQ(Run("simulate --fault C8=10e-6@10 -o run.csv").exit_code, 0);
  const std::string asked = "study run.csv --k 100 --km 100:20 --order 1,2,3,4";
  const Finished run = Run(asked + " --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  ASSERT_EQ(answer.at("variants").as_array().size(), 8U);
  for (const json::value& variant : answer.at("variants").as_array()) {
    const json::value& left = variant.at("left").at("after");
    const auto order = variant.at("order").to_number<std::size_t>();
    EXPECT_EQ(variant.at("parameters").as_array().size(), 2 * order + 1);
    EXPECT_GT(left.at("count").to_number<int>(), 800);
    const bool swa = variant.at("method") == "swa";
    EXPECT_EQ(left.at("order").to_number<int>() > 1, swa) << "C8 is a lag of its own";
    EXPECT_LT(left.at("rms").to_number<double>(), 0.2);
  }
  const Finished text = Run(asked);
  for (const char* part : {"swa_100_o4", "Ljung-Box", "SWA, K = 100:", "after it"}) {
    EXPECT_NE(text.out.find(part), std::string::npos) << part << "\n" << text.out;
  }
}

TEST_F(CliStudy, EndsAtTheNextChangeAndLeavesOutWhatDoesNotFit) {
  ASSERT_EQ(Run("simulate --fault R1=10@10to15 --duration 30 -o run.csv").exit_code, 0);
  const Finished run = Run("study run.csv --k 100,600 --km \"\" --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  EXPECT_EQ(answer.at("change_s"), 10.0);
  EXPECT_EQ(answer.at("until_s"), 15.0);
  EXPECT_EQ(answer.at("left_out").at(0), "swa_600");
  const json::value& b0d = answer.at("variants").at(0).at("parameters").at(0).at("after");
  EXPECT_NEAR(b0d.at("mean").to_number<double>(), 1.32, 0.05) << "of the fault alone";
  EXPECT_LT(b0d.at("sd").to_number<double>(), 0.05);
  // The same change, told by somebody who has it from the estimate; and the next one.
  const json::value near =
      json::parse(Run("study run.csv --k 100 --km \"\" --change 9.9 --json").out);
  EXPECT_EQ(near.at("until_s"), 15.0);
  const json::value back =
      json::parse(Run("study run.csv --k 100 --km \"\" --change 15 --json").out);
  EXPECT_EQ(back.at("from_s"), 10.0) << "of the fault alone, not of what was before it";
  const json::value& faulty = back.at("variants").at(0).at("parameters").at(0).at("before");
  EXPECT_NEAR(faulty.at("mean").to_number<double>(), 1.32, 0.05);
  const json::value later =
      json::parse(Run("study run.csv --k 100 --km \"\" --from 12 --json").out);
  EXPECT_EQ(later.at("change_s"), 15.0) << "the first behind the start";
}

TEST_F(CliStudy, RefusesWindowsThatCannotBeByName) {
  ASSERT_EQ(Run("simulate --duration 6 -o run.csv").exit_code, 0);
  const std::pair<std::string, std::string> cases[] = {
      {"--k 50,x", "faultlab: --k: Give windows K in samples, such as 50,100,200.\n"},
      {"--km 20", "faultlab: --km: Give pairs K:m in samples, such as 20:5,100:20.\n"},
      {"--order 0", "faultlab: --order: Give orders from 1 to 4, such as 1,2.\n"},
      {"--order 1,5", "faultlab: --order: Give orders from 1 to 4, such as 1,2.\n"},
      {"--k \"\" --km \"\"", "faultlab: --k: Ask for 1 to 48 windows and orders at once.\n"},
      {"--change 6",
       "faultlab: --change: The change must lie inside the record, after its start.\n"},
      {"--change 0.2",
       "faultlab: --change: The change must lie inside the record, after its start.\n"},
      {"--from -1", "faultlab: --from: The start is a time in seconds, 0 or more.\n"},
      {"--change soon", "faultlab: --change: Give auto, none or a time in seconds.\n"},
      {"--k 3 --km \"\"", "faultlab: --k: the window K must be 6 to 100000 samples\n"},
      {"--k 5000 --km \"\"", "faultlab: run.csv: This stretch is too short for every window.\n"},
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
