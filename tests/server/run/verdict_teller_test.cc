#include "server/run/verdict_teller.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

core::Verdict Naming(std::vector<std::string_view> symbols, std::string_view best) {
  core::Verdict verdict;
  verdict.kind = core::VerdictKind::kFault;
  verdict.detected_at_s = 10.0;
  verdict.reason = "why";
  for (const std::string_view symbol : symbols) {
    const core::Component component = *paper::Bench().Find(symbol);
    verdict.group.push_back(component);
    core::Candidate candidate;
    candidate.component = component;
    candidate.value = 33e3;
    if (symbol == best) {
      verdict.candidates.insert(verdict.candidates.begin(), candidate);
    } else {
      verdict.candidates.push_back(candidate);
    }
  }
  return verdict;
}

TEST(VerdictTeller, AGroupIsToldOnceWhicheverOfItFitsBestAtTheMoment) {
  VerdictTeller teller(0.01);
  const auto told = teller.Hear(Naming({"R12", "R9"}, "R12"), 1020);
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].kind, "detected");
  EXPECT_EQ(told[1].kind, "isolated");
  const json::object isolated = json::parse(told[1].json).as_object();
  EXPECT_EQ(json::serialize(isolated.at("components")), R"(["R9","R12"])") << "as on the bench";
  EXPECT_FALSE(isolated.contains("component")) << "no sensor tells them apart";
  EXPECT_FALSE(isolated.contains("value"));
  for (int second = 1; second < 5; ++second) {
    const char* best = second % 2 == 0 ? "R12" : "R9";
    EXPECT_TRUE(teller.Hear(Naming({"R9", "R12"}, best), 1020 + 100 * second).empty());
  }
}

TEST(VerdictTeller, OneAloneHasItsValueAndANewNameIsNews) {
  VerdictTeller teller(0.01);
  const auto alone = teller.Hear(Naming({"R9"}, "R9"), 1020);
  const json::object first = json::parse(alone.at(1).json).as_object();
  EXPECT_EQ(first.at("component"), "R9");
  EXPECT_EQ(first.at("value").to_number<double>(), 33e3);
  const auto group = teller.Hear(Naming({"R9", "R12"}, "R9"), 1100);
  ASSERT_EQ(group.size(), 1U);
  EXPECT_EQ(group[0].kind, "isolated");
}

}  // namespace
}  // namespace faultlab::server
