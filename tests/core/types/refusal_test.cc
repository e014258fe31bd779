#include <gtest/gtest.h>

#include "core/types/result.h"

namespace faultlab::core {
namespace {

TEST(Refuse, HasCodeAndSentenceOfItsReasonAndKeepsWhatWasGiven) {
  const Error error =
      Refuse("other_bench", "/bench", {{"rig", "r1"}, {"bench", "a"}, {"asked", "b"}});
  EXPECT_EQ(error.code, ErrorCode::kInvalid);
  EXPECT_EQ(error.message, "r1 is of the bench a, not of b.");
  EXPECT_EQ(error.field, "/bench");
  EXPECT_EQ(error.reason, "other_bench");
  ASSERT_EQ(error.parameters.size(), 3u);
  EXPECT_EQ(error.parameters[2].value, "b");
  EXPECT_EQ(Refuse("no_ticket").As(ErrorCode::kConflict).code, ErrorCode::kConflict);
}

TEST(Refuse, DoesNotLookForPlacesInWhatPeopleWrote) {
  EXPECT_EQ(
      Refuse("other_bench", "", {{"rig", "{asked} {"}, {"bench", "}"}, {"asked", "x"}}).message,
      "{asked} { is of the bench }, not of x.");
}

TEST(Refuse, SaysOneOfOneThing) {
  EXPECT_EQ(Refuse("your_runs_full", "", {{"most", 1}}).message,
            "You have 1 run in progress, the most that one person may have. Stop it or wait.");
  EXPECT_EQ(Refuse("your_runs_full", "", {{"most", 11}}).message,
            "You have 11 runs in progress, the most that one person may have. Stop one or wait.");
}

TEST(Refuse, WritesNumbersAsPeopleDo) {
  const auto said = [](const ErrorParameter& parameter) { return parameter.value; };
  EXPECT_EQ(said({"x", 0.00001}), "0.00001");
  EXPECT_EQ(said({"x", 12.5}), "12.5");
  EXPECT_EQ(said({"x", 1e12}), "1000000000000");
  EXPECT_EQ(said({"x", 1e-30}), "1e-30");
  EXPECT_EQ(said({"x", 0.1 + 0.2}), "0.30000000000000004");
  EXPECT_EQ(said({"x", std::int64_t{-7}}), "-7");
}

TEST(Refuse, KnowsItsReasons) {
  EXPECT_THROW((void)Refuse("no_such_reason"), ContractError);
}

}  // namespace
}  // namespace faultlab::core
