#include "server/course/fault_pool.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <map>
#include <set>

#include "server/course/commitment.h"
#include "tests/paper_bench.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

core::Result<FaultPool> Parse(const std::string& text) {
  return ParsePool(json::parse(text).as_object(), paper::Bench());
}

FaultPool PoolOf(const std::string& text) {
  auto pool = Parse(text);
  EXPECT_TRUE(pool.ok()) << pool.error().message;
  return std::move(pool).value();
}

std::string RefusalOf(const std::string& items) {
  const auto pool = Parse(R"({"items":[)" + items + "]}");
  EXPECT_FALSE(pool.ok());
  return pool.ok() ? "" : pool.error().field + " " + pool.error().reason;
}

constexpr const char* kThree = R"({"healthy_share":0.25,"items":[
  {"component":"R1","low":40,"high":90,"onset_from_s":8,"onset_to_s":12},
  {"component":"Ra","values":[6,9],"onset_from_s":8,"weight":2},
  {"component":"J","low":1e-5,"high":1e-5,"kind":"drift","lasts_s":3,"onset_from_s":9}]})";

TEST(FaultPool, RefusesByName) {
  const std::string good = R"("component":"R1","low":40,"high":90)";
  EXPECT_EQ(RefusalOf(""), "/pool/items no_faults");
  EXPECT_EQ(RefusalOf("1"), "/pool/items/0 faults_unreadable");
  EXPECT_EQ(RefusalOf(R"({"component":"X","low":1,"high":2,"onset_from_s":8})"),
            "/pool/items/0/component no_component");
  EXPECT_EQ(RefusalOf("{" + good + R"(,"onset_from_s":4})"),
            "/pool/items/0/onset_from_s onset_too_early");
  EXPECT_EQ(RefusalOf("{" + good + R"(,"onset_from_s":9,"onset_to_s":8})"),
            "/pool/items/0/onset_to_s pool_range_backwards");
  EXPECT_EQ(RefusalOf(R"({"component":"R1","low":90,"high":40,"onset_from_s":8})"),
            "/pool/items/0/high pool_range_backwards");
  EXPECT_EQ(RefusalOf(R"({"component":"R1","values":[0],"onset_from_s":8})"),
            "/pool/items/0/values fault_value_not_positive");
  EXPECT_EQ(RefusalOf("{" + good + R"(,"onset_from_s":8,"kind":"drift"})"),
            "/pool/items/0/lasts_s member_missing");
  EXPECT_EQ(RefusalOf("{" + good + R"(,"onset_from_s":8,"odd":1})"),
            "/pool/items/0/odd member_unknown");
}

TEST(FaultPool, TheHardestToSeeLieNearestToNominal) {
  const FaultPool pool = PoolOf(R"({"items":[
    {"component":"R1","values":[0.2,0.5,10,100],"onset_from_s":8},
    {"component":"Ra","low":9,"high":20,"onset_from_s":8},
    {"component":"J","low":1e-7,"high":1e-4,"onset_from_s":8}]})");
  std::vector<std::pair<std::string, double>> hardest;
  for (const core::Fault& fault : HardestToSee(pool, paper::Bench().nominal)) {
    hardest.emplace_back(core::Name(fault.component), fault.value);
  }
  EXPECT_EQ(hardest,
            (std::vector<std::pair<std::string, double>>{
                {"R1", 0.5}, {"R1", 10.0}, {"Ra", 9.0}, {"J", 1e-7}, {"J", 1e-4}}));
}

TEST(FaultPool, IsReadAgainAsItWasWritten) {
  const FaultPool pool = PoolOf(kThree);
  const std::string text = json::serialize(ToJson(pool));
  EXPECT_EQ(json::serialize(ToJson(ParsePool(text, paper::Bench()).value())), text);
  EXPECT_DOUBLE_EQ(LastsUntil(pool), 12.0);
  const std::vector<core::Fault> stand = Representatives(pool);
  ASSERT_EQ(stand.size(), 3U);
  EXPECT_DOUBLE_EQ(stand[0].value, 60.0);
  EXPECT_DOUBLE_EQ(stand[0].at_s, 10.0);
  EXPECT_DOUBLE_EQ(stand[2].until_s, 12.0);
}

TEST(FaultPool, DrawsTheSameForTheSameSeed) {
  const FaultPool pool = PoolOf(kThree);
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    int one = 0;
    int two = 0;
    const auto first = Draw(pool, {}, seed, &one);
    const auto second = Draw(pool, {}, seed, &two);
    ASSERT_EQ(first.size(), second.size());
    EXPECT_EQ(one, two);
    for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].value, second[i].value);
  }
}

TEST(FaultPool, DrawsWithinItsRangesAndByItsWeights) {
  const FaultPool pool = PoolOf(kThree);
  std::map<int, int> count;
  constexpr int kDraws = 4000;
  for (int seed = 0; seed < kDraws; ++seed) {
    int item = 0;
    const auto faults = Draw(pool, {}, static_cast<std::uint64_t>(seed), &item);
    ++count[item];
    ASSERT_EQ(faults.empty(), item < 0);
    if (item == 0) {
      EXPECT_GE(faults[0].value, 40.0);
      EXPECT_LE(faults[0].value, 90.0);
      EXPECT_GE(faults[0].at_s, 8.0);
      EXPECT_LE(faults[0].at_s, 12.0);
    } else if (item == 1) {
      EXPECT_TRUE(faults[0].value == 6.0 || faults[0].value == 9.0);
    }
  }
  // Five standard deviations of a count.
  EXPECT_NEAR(count[-1], 0.25 * kDraws, 140);
  EXPECT_NEAR(count[0], 0.1875 * kDraws, 125);
  EXPECT_NEAR(count[1], 0.375 * kDraws, 155);
}

/// Whoever has had a fault gets the others first: then students' sets are equally hard.
TEST(FaultPool, GivesAPersonTheWholePoolBeforeAnythingTwice) {
  FaultPool pool = PoolOf(kThree);
  pool.healthy_share = 0.0;
  for (std::uint64_t person = 0; person < 20; ++person) {
    std::vector<int> had;
    for (std::uint64_t n = 0; n < 6; ++n) {
      int item = 0;
      Draw(pool, had, person * 100 + n, &item);
      had.push_back(item);
    }
    EXPECT_EQ(std::set<int>(had.begin(), had.begin() + 3).size(), 3U);
    EXPECT_EQ(std::set<int>(had.begin() + 3, had.end()).size(), 3U);
  }
}

TEST(Commitment, BindsAndHides) {
  const Commitment one = CommitTo("truth");
  const Commitment two = CommitTo("truth");
  EXPECT_NE(one.hash, two.hash) << "otherwise short truths could be tried out";
  EXPECT_EQ(CommitmentOf(one.nonce, "truth"), one.hash);
  EXPECT_NE(CommitmentOf(one.nonce, "other"), one.hash);
  // printf '%s%s' abc def | sha256sum
  EXPECT_EQ(CommitmentOf("abc", "def"),
            "bef57ec7f53a6d40beb640a780a639c83bc29ac8a9816f1fc6c5c6dcd93c4721");
}

}  // namespace
}  // namespace faultlab::server::course
