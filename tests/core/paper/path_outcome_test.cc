#include "core/paper/path_outcome.h"

#include <gtest/gtest.h>

#include "tests/paper_bench.h"

namespace faultlab::core {
namespace {

Verdict RunThatEndsAt(std::vector<Component> end) {
  Verdict verdict;
  verdict.kind = VerdictKind::kFault;
  verdict.settled = true;
  verdict.candidates = {{.component = paper::kR1, .value = 10.0, .sigma = 0.1}};
  verdict.path = {{"a1 outside its band?", true, -0.09, 0.0059, "b0", {}},
                  {"a1 and b0 in opposite directions?", false, -0.09, 0.0, "", std::move(end)}};
  return verdict;
}

TEST(PathOutcome, AgreesWhenOneOfTheVerdictsGroupIsAtItsEnd) {
  Verdict verdict = RunThatEndsAt({paper::kR12, paper::kJ});
  EXPECT_EQ(ComparePath(verdict), PathOutcome::kWindow);
  verdict.group = {paper::kJ, paper::kR1};
  EXPECT_EQ(ComparePath(verdict), PathOutcome::kAgrees);
  EXPECT_EQ(NamedBy(verdict), (std::vector{paper::kR1, paper::kJ})) << "in the bench's order";
  EXPECT_EQ(ComparePath(RunThatEndsAt({paper::kR1})), PathOutcome::kAgrees);
  EXPECT_EQ(ComparePath(RunThatEndsAt({})), PathOutcome::kWindow) << "nominal is no component";
}

TEST(PathOutcome, SaysWhyItDiffersByTheFirstReasonThatHolds) {
  Verdict verdict = RunThatEndsAt({paper::kJ});
  verdict.path.front().threshold = 0.06;
  EXPECT_EQ(ComparePath(verdict), PathOutcome::kClose);
  EXPECT_TRUE(IsClose(verdict.path.front()));
  EXPECT_FALSE(IsClose(verdict.path.back())) << "a direction has no limit to be close to";
  verdict.settled = false;
  EXPECT_EQ(ComparePath(verdict), PathOutcome::kSettling);
  verdict.kind = VerdictKind::kUnknownFault;
  EXPECT_EQ(ComparePath(verdict), PathOutcome::kUnknown);
}

TEST(PathOutcome, ComparesNothingWithoutAPathOrAFault) {
  Verdict verdict = RunThatEndsAt({paper::kJ});
  verdict.kind = VerdictKind::kNominal;
  EXPECT_EQ(ComparePath(verdict), PathOutcome::kNothing);
  verdict.kind = VerdictKind::kFault;
  verdict.candidates.clear();
  EXPECT_EQ(ComparePath(verdict), PathOutcome::kNothing);
  EXPECT_EQ(ComparePath(Verdict{}), PathOutcome::kNothing);
}

}  // namespace
}  // namespace faultlab::core
