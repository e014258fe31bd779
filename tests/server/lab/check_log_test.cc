#include "server/lab/check_log.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/support/engines.h"
#include "tests/support/test_database.h"

namespace faultlab::server::lab {
namespace {

using testing::IsEmpty;
using testing::SizeIs;

class CheckLogTest : public testing::TestWithParam<Engine> {
 protected:
  tests::TestDatabase database_{GetParam()};
  CheckLog log_{*database_};
};

TEST_P(CheckLogTest, GivesBackEachStepWithItsFigure) {
  CheckRecord check{.rig = "bench-1", .at = FromMilliseconds(5000), .kind = "self_test"};
  check.reason = "b0d is 1.3 of its norm";
  check.steps.push_back({.step = "interlock", .passed = true});
  check.steps.push_back({.step = "relay", .subject = "R1 = 56, Do1", .passed = true});
  check.steps.push_back({.step = "b0d",
                         .figure = CheckStep::Figure{1.3, 0.9, 1.1, "1/V"},
                         .text = "b0d is 1.3 of its norm"});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  check.steps.push_back({.step = "a1d", .figure = CheckStep::Figure{nan, -0.9, -0.7, ""}});
  ASSERT_TRUE(log_.Add(check).ok());
  const auto found = log_.List("bench-1").value();
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].at, check.at);
  EXPECT_EQ(found[0].kind, "self_test");
  EXPECT_FALSE(found[0].passed);
  EXPECT_EQ(found[0].reason, check.reason);
  ASSERT_THAT(found[0].steps, SizeIs(4));
  EXPECT_EQ(found[0].steps[1].subject, "R1 = 56, Do1");
  EXPECT_TRUE(found[0].steps[1].passed);
  EXPECT_FALSE(found[0].steps[1].figure.has_value());
  ASSERT_TRUE(found[0].steps[2].figure.has_value());
  EXPECT_EQ(found[0].steps[2].figure->measured, 1.3);
  EXPECT_EQ(found[0].steps[2].figure->high, 1.1);
  EXPECT_EQ(found[0].steps[2].figure->unit, "1/V");
  EXPECT_FALSE(found[0].steps[3].figure.has_value()) << "a database has no NaN";
  EXPECT_THAT(log_.List("bench-2").value(), IsEmpty());
}

TEST_P(CheckLogTest, KeepsTheNewestTwentyOfEachRig) {
  for (int i = 0; i < CheckLog::kKept + 5; ++i) {
    const CheckRecord check{.rig = "bench-1",
                            .at = FromMilliseconds(i),
                            .kind = "between_users",
                            .passed = true,
                            .steps = {{.step = "interlock", .passed = true}}};
    ASSERT_TRUE(log_.Add(check).ok());
  }
  ASSERT_TRUE(log_.Add({.rig = "bench-2", .kind = "commission", .passed = true}).ok());
  const auto found = log_.List("bench-1").value();
  ASSERT_THAT(found, SizeIs(CheckLog::kKept));
  EXPECT_EQ(found.front().at, FromMilliseconds(CheckLog::kKept + 4)) << "newest first";
  EXPECT_THAT(found.back().steps, SizeIs(1));
  EXPECT_THAT(log_.List("bench-2").value(), SizeIs(1));
}

INSTANTIATE_TEST_SUITE_P(Engines, CheckLogTest, tests::kBothEngines, tests::EngineName);

}  // namespace
}  // namespace faultlab::server::lab
