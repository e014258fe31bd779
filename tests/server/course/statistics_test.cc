#include "server/course/statistics.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace faultlab::server::course {
namespace {

constexpr WallTime kReleased{std::chrono::milliseconds(1'700'000'000'000)};

/// @param truth   "" of a healthy rig
/// @param answer  "" healthy; "-": none
Trial Of(std::int64_t person, const std::string& truth, const std::string& answer, double points) {
  Trial trial;
  trial.account = person;
  trial.state = answer == "-" ? TrialState::kOpen : TrialState::kAnswered;
  trial.released_at = kReleased;
  trial.truth = truth.empty() ? R"({"faults":[],"seed":1})"
                              : R"({"faults":[{"component":")" + truth + R"("}],"seed":1})";
  if (answer == "-") return trial;
  trial.answer =
      R"({"component":)" + (answer.empty() ? std::string("null") : "\"" + answer + "\"") + "}";
  trial.grade = R"({"right":)" + std::string(truth == answer ? "true" : "false") + R"(,"points":)" +
                std::to_string(points) + "}";
  return trial;
}

TEST(Statistics, CountsWhatWasSaidOfEachFault) {
  std::vector<Trial> trials = {Of(1, "R1", "R1", 90),
                               Of(2, "R1", "Ra", 30),
                               Of(3, "R1", "Ra", 20),
                               Of(4, "R1", "-", 0),
                               Of(1, "", "", 100)};
  trials.push_back(Of(5, "R1", "R1", 100));
  trials.back().released_at.reset();  // sealed
  trials.push_back(Of(6, "R1", "R1", 100));
  trials.back().state = TrialState::kVoid;
  trials[2].awarded = R"({"points":60,"reason":"x","by":"t"})";
  const Statistics all = StatisticsOf(trials);
  EXPECT_EQ(all.students, 4);
  EXPECT_EQ(all.answered, 4);
  EXPECT_DOUBLE_EQ(all.points.value(), 70.0);
  ASSERT_EQ(all.faults.size(), 2U);
  EXPECT_EQ(all.faults[0].fault, "") << "the healthy rig comes first";
  const FaultStatistics& r1 = all.faults[1];
  EXPECT_EQ(r1.trials, 4);
  EXPECT_EQ(r1.answered, 3);
  EXPECT_DOUBLE_EQ(r1.right, 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(r1.points, 60.0);
  ASSERT_EQ(r1.answers.size(), 2U);
  EXPECT_EQ(r1.answers[0], (std::pair<std::string, int>("Ra", 2)));
}

TEST(Statistics, TellWhetherThoseWhoKnowMoreFindAFault) {
  std::vector<Trial> fair;
  std::vector<Trial> odd;
  for (int person = 0; person < 10; ++person) {
    const double knows = 10.0 * person;
    fair.push_back(Of(person, "J", "J", knows));
    fair.push_back(Of(person, "R1", person >= 5 ? "R1" : "Ra", knows));
    odd.push_back(Of(person, "J", "J", knows));
    odd.push_back(Of(person, "R1", person < 5 ? "R1" : "Ra", knows));
  }
  // 0/1 against 0, 10, .. 90: covariance 12.5, deviations 0.5 and 28.723
  EXPECT_NEAR(StatisticsOf(fair).faults[1].discrimination.value(), 0.8704, 1e-4);
  EXPECT_NEAR(StatisticsOf(odd).faults[1].discrimination.value(), -0.8704, 1e-4);
  EXPECT_FALSE(StatisticsOf(fair).faults[0].discrimination) << "everybody found it";
  EXPECT_FALSE(
      StatisticsOf(std::vector<Trial>(fair.begin(), fair.begin() + 4)).faults[1].discrimination)
      << "two persons";
}

TEST(Statistics, OfNothingAreEmpty) {
  const Statistics none = StatisticsOf({});
  EXPECT_EQ(none.students, 0);
  EXPECT_FALSE(none.points);
}

}  // namespace
}  // namespace faultlab::server::course
