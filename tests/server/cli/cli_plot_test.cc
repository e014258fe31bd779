#include <gtest/gtest.h>

#include <array>
#include <boost/json/parse.hpp>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "core/types/number_text.h"
#include "tests/server/cli/child_program.h"
#include "tests/support/paths.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
const std::string kRecording = tests::InSource("tests/data/r1_33ohm.csv.gz");

class CliPlot : public ChildProgram {};

int BigEndian(const std::string& bytes, std::size_t at) {
  int value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value = value * 256 + static_cast<unsigned char>(bytes[at + i]);
  }
  return value;
}

TEST_F(CliPlot, DrawsEveryFigureOfARecording) {
  for (const std::string figure :
       {"signals", "swa", "sia", "models", "friction", "steps", "decisions"}) {
    const Finished run =
        Run("plot " + kRecording + " --figure " + figure + " -o " + figure + ".png");
    ASSERT_EQ(run.exit_code, 0) << figure << ": " << run.err;
    const std::string png = Read(figure + ".png");
    ASSERT_GT(png.size(), 10'000u);
    EXPECT_EQ(png.substr(1, 3), "PNG");
    EXPECT_EQ(BigEndian(png, 16), 1600);
    EXPECT_EQ(BigEndian(png, 20), 900);
  }
}

TEST_F(CliPlot, GivesEstimatesOfACurrentTheirUnits) {
  ASSERT_EQ(Run("simulate --bench gear-motor -o run.csv").exit_code, 0);
  ASSERT_EQ(Run("plot run.csv --bench gear-motor --figure sia -o sia.json").exit_code, 0);
  const std::string figure = Read("sia.json");
  EXPECT_NE(figure.find("A/V"), std::string::npos);
  EXPECT_EQ(figure.find("V/V"), std::string::npos);
  ASSERT_EQ(Run("plot run.csv --bench gear-motor --figure models -o models.json").exit_code, 0);
  const json::value models = json::parse(Read("models.json"));
  EXPECT_EQ(models.at("panels").at(0).at("y").at("unit"), "A");
}

TEST_F(CliPlot, MarksTheFaultThatTheFileNames) {
  ASSERT_EQ(Run("simulate --fault C8=10u@10 -o run.csv").exit_code, 0);
  ASSERT_EQ(Run("plot run.csv -o figure.json").exit_code, 0);
  const json::value figure = json::parse(Read("figure.json"));
  EXPECT_EQ(figure.at("marks").at(0).at("kind"), "fault");
  EXPECT_EQ(figure.at("marks").at(0).at("x"), 10.0);
  EXPECT_EQ(figure.at("marks").at(0).at("label"), "C8 = 10 µF");
}

TEST_F(CliPlot, RefusesWhatItCannotDrawAndKeepsTheOldFile) {
  Write("old.png", "old");
  Finished run = Run("plot " + kRecording + " --figure spectrum -o old.png");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err,
            "faultlab: unknown figure 'spectrum', expected one of signals, swa, sia, models, "
            "friction, steps, decisions\n");
  run = Run("plot " + kRecording + " --scale 5 -o old.png");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err, "faultlab: scale must be 1 or 2\n");
  run = Run("plot run-1234 -o old.png");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err,
            "faultlab: 'run-1234' is no CSV file, and there is no database of runs at "
            "data/faultlab.db; name a file or the folder with --data\n");
  run = Run("plot " + kRecording + " -o old.png", "FAULTLAB_FONT=/none.ttf");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("fonts-dejavu-core"), std::string::npos);
  EXPECT_EQ(Read("old.png"), "old");
  EXPECT_EQ(Listing(), "old.png");
}

TEST_F(CliPlot, DrawsAFamilyOfCurvesOfSeveralRecordings) {
  ASSERT_EQ(Run("simulate --duration 14 -o a.csv").exit_code, 0);
  ASSERT_EQ(Run("simulate --duration 14 --fault R1=56@10 -o b.csv").exit_code, 0);
  ASSERT_EQ(Run("simulate --duration 14 --fault R1=10@10 -o c.csv").exit_code, 0);
  ASSERT_EQ(Run("simulate --duration 14 --fault C8=10e-6@10 -o d.csv").exit_code, 0);
  const Finished run = Run("plot a.csv b.csv c.csv d.csv --figure curves -o curves.json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value figure = json::parse(Read("curves.json"));
  ASSERT_EQ(figure.at("panels").as_array().size(), 2U) << "one a component";
  std::vector<std::string> legend;
  for (const json::value& series : figure.at("panels").at(1).at("series").as_array()) {
    legend.emplace_back(series.at("name").as_string());
    EXPECT_EQ(series.at("x").at(0).to_number<double>(), -0.5) << "before its change";
  }
  EXPECT_EQ(legend, (std::vector<std::string>{"healthy", "R1 = 10 Ω", "R1 = 56 Ω"}));
  EXPECT_EQ(Run("plot a.csv b.csv -o two.png").err,
            "faultlab: several recordings are drawn by --figure curves\n");
  std::string many = "plot";
  for (int i = 0; i < 16; ++i) many += " a.csv";
  EXPECT_EQ(Run(many + " --figure curves -o many.png").err,
            "faultlab: --figure curves draws at most 15 recordings\n");
}

using CliReproduce = ChildProgram;

TEST_F(CliReproduce, HoldsEveryTableOfThePaperBesideOurs) {
  const Finished run = Run("reproduce --json --repetitions 1");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::value answer = json::parse(run.out);
  std::set<std::int64_t> tables;
  for (const json::value& table : answer.at("tables").as_array()) {
    tables.insert(table.at("table").to_number<std::int64_t>());
    EXPECT_FALSE(table.at("rows").as_array().empty());
  }
  EXPECT_EQ(tables.size(), 18u);
  EXPECT_EQ(*tables.begin(), 3);
  EXPECT_EQ(*tables.rbegin(), 20);
  const json::value& row = answer.at("tables").at(4).at("rows").at(0);
  EXPECT_EQ(row.at("fault").at("component"), "R1");
  EXPECT_EQ(row.at("name"), "b0");
  EXPECT_EQ(row.at("paper"), 2.306);
  EXPECT_NEAR(row.at("ours").to_number<double>(), 2.306, 0.1);
  const Finished text = Run("reproduce --repetitions 1");
  EXPECT_NE(text.out.find("Table 20"), std::string::npos);
  EXPECT_NE(text.out.find("Summary"), std::string::npos);
}

TEST_F(CliReproduce, SaysOneNumberForOneThing) {
  const Finished run = Run("reproduce --json --repetitions 3 --plots figures");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json::object answer = json::parse(run.out).as_object();
  const auto ours = [&](int table, std::string_view name, std::string_view part, double value) {
    for (const json::value& row : answer.at("tables").at(table - 3).at("rows").as_array()) {
      const json::value& fault = row.at("fault");
      const bool same = value == 0.0
                            ? fault.is_null()
                            : fault.is_object() && fault.at("component").as_string() == part &&
                                  fault.at("value").to_number<double>() == value;
      if (same && row.at("name").as_string() == name) return row.at("ours").to_number<double>();
    }
    return std::nan("");
  };
  std::set<std::int64_t> numbers;
  const json::object* models = nullptr;
  for (const json::value& figure : answer.at("figures").as_array()) {
    const auto number = figure.at("number").to_number<std::int64_t>();
    numbers.insert(number);
    EXPECT_TRUE(Exists("figures/figure_" + std::to_string(number) + ".png")) << number;
    if (number == 23) models = &figure.as_object();
  }
  EXPECT_EQ(numbers, (std::set<std::int64_t>{4, 6, 14, 15, 16, 17, 18, 19, 20, 21, 23}));
  ASSERT_NE(models, nullptr);
  const json::array& legend = models->at("panels").at(0).at("series").as_array();
  const std::array<const char*, 5> names = {"swa", "sia", "mc_0", "mc_0.48mNm", "mc_0.33mNm"};
  ASSERT_EQ(legend.size(), 1 + names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::string text(legend.at(1 + i).at("name").as_string());
    constexpr std::string_view kMinus = "\u2212";
    if (const auto at = text.find(kMinus); at != text.npos) text.replace(at, kMinus.size(), "-");
    const double table = ours(14, names[i], "R1", 100.0);
    EXPECT_TRUE(text.ends_with(core::Format("  %.1f %%", table)))
        << text << ", Table 14: " << table;
  }
  const json::value& summary = answer.at("summary");
  EXPECT_EQ(summary.at("nominal_fit_swa_percent").to_number<double>(), ours(13, "swa", "", 0.0));
  EXPECT_EQ(summary.at("nominal_fit_sia_percent").to_number<double>(), ours(13, "sia", "", 0.0));
}

using CliAdmin = ChildProgram;

TEST_F(CliAdmin, NeverMakesADatabaseByAccident) {
  const Finished run = Run("admin check --data lab");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err,
            "faultlab: there is no database at lab/faultlab.db; name its folder with --data, or "
            "start the server once\n");
  EXPECT_EQ(Listing(), "");
}

}  // namespace
}  // namespace faultlab::server
