#include "server/api/bench/bench_json.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/paper/paper_tables.h"
#include "hardware/simulated/simulated_rig.h"
#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

const json::object& Find(const json::object& bench, std::string_view symbol) {
  for (const json::value& component : bench.at("components").as_array()) {
    if (component.at("symbol").as_string() == symbol) return component.as_object();
  }
  throw std::out_of_range(std::string(symbol));
}

TEST(BenchJson, NamesTheRelayLinesThatARigsSelfTestWalks) {
  hardware::SimulatedRigOptions options;
  options.speed = 0.0;
  const auto rig = hardware::MakeSimulatedRig(options);
  const auto report = rig->SelfTest(hardware::Epoch{1});
  ASSERT_TRUE(report.ok());
  std::map<std::pair<std::string, double>, std::string> walked;
  for (const hardware::SelfTestPosition& each : report.value().positions) {
    walked[{std::string(core::Name(each.component)), each.value}] = each.line;
  }
  ASSERT_EQ(walked.size(), 16u);
  std::map<std::pair<std::string, double>, std::string> shown;
  const json::object bench = BenchToJson(paper::Bench());
  for (const json::value& component : bench.at("components").as_array()) {
    for (const json::value& value : component.at("values").as_array()) {
      if (component.at("switched_by") != "relay") continue;
      shown[{std::string(component.at("symbol").as_string()), value.at("value").as_double()}] =
          std::string(value.at("line").as_string());
    }
  }
  EXPECT_EQ(shown, walked);
}

TEST(BenchJson, OffersEveryPublishedFaultAndTheNominalValueFirst) {
  const json::object bench = BenchToJson(paper::Bench());
  EXPECT_EQ(bench.at("published").at("faults").as_array().size(), 18u);
  for (const core::PaperFault& fault : core::PrintedFaults()) {
    const json::object& component = Find(bench, std::string(fault.component));
    std::set<double> offered;
    for (const json::value& each : component.at("values").as_array()) {
      offered.insert(each.at("value").as_double());
    }
    EXPECT_TRUE(offered.contains(fault.value)) << std::string(fault.component) << fault.value;
    EXPECT_EQ(component.at("values").at(0).at("value"), component.at("nominal"));
    EXPECT_EQ(offered.size(), 4u);
  }
}

TEST(BenchJson, SaysWhatEachComponentMovesInTheModel) {
  const json::object bench = BenchToJson(paper::Bench());
  const std::map<std::string, std::string> expected = {{"R1", R"(["b0","b1","a1"])"},
                                                       {"R9", R"(["b0","b1"])"},
                                                       {"R12", R"(["b0","b1"])"},
                                                       {"C8", R"(["b1","a1"])"},
                                                       {"Ra", R"(["b1","a1"])"},
                                                       {"J", R"(["b1","a1"])"},
                                                       {"B", R"(["b0","b1","a1"])"}};
  for (const auto& [symbol, moves] : expected) {
    EXPECT_EQ(json::serialize(Find(bench, symbol).at("moves")), moves) << symbol;
  }
}

TEST(BenchJson, GivesTheModelOfThePaperSampledWithTheDelay) {
  const json::object at_edge = ModelToJson(paper::Plant(), 0.01, 0.0);
  EXPECT_NEAR(at_edge.at("sia").at(0).as_double(), 2.3935, 5e-5);
  EXPECT_NEAR(at_edge.at("sia").at(1).as_double(), 0.0382, 5e-5);
  EXPECT_NEAR(at_edge.at("sia").at(2).as_double(), 0.01807, 5e-6);
  EXPECT_NEAR(at_edge.at("swa").at(0).as_double(), 2.1146, 5e-4);
  EXPECT_NEAR(at_edge.at("swa").at(1).as_double(), -1.0975, 5e-4);
  EXPECT_NEAR(at_edge.at("swa").at(2).as_double(), -0.5751, 5e-5);
  const json::object late = ModelToJson(paper::Plant(), 0.01, 0.0095);
  EXPECT_EQ(late.at("sia"), at_edge.at("sia"));
  EXPECT_NE(late.at("swa").at(0), at_edge.at("swa").at(0));
  EXPECT_EQ(late.at("swa").at(2), at_edge.at("swa").at(2));
}

}  // namespace
}  // namespace faultlab::server
