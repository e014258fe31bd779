#include "server/course/grade.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>

#include "tests/paper_bench.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

core::Component Named(const char* symbol) {
  return *paper::Bench().Find(symbol);
}

/// R1 = 60 ohm with 1 %; C8 cannot be told from it.
core::Diagnosis Diagnosed() {
  core::Diagnosis diagnosis;
  core::Candidate r1;
  r1.component = Named("R1");
  r1.value = 60.0;
  r1.sigma = 0.6;
  core::Candidate c8 = r1;
  c8.component = Named("C8");
  c8.value = 2e-6;
  c8.sigma = 4e-7;
  diagnosis.verdict.candidates = {r1, c8};
  diagnosis.verdict.group = {Named("R1"), Named("C8")};
  return diagnosis;
}

const core::Fault kFault{Named("R1"), 60.0, 8.0, core::FaultKind::kAbrupt, 0.0};

Answer Says(const char* symbol, double value, double confidence = 1.0) {
  Answer answer;
  if (symbol != nullptr) answer.component = Named(symbol);
  answer.value = value;
  answer.confidence = confidence;
  return answer;
}

Grade Of(const Answer& answer, std::vector<core::Fault> truth = {kFault}, double length_s = 20.0) {
  return GradeAnswer(answer, truth, Diagnosed(), Rubric{}, 0.0, length_s);
}

TEST(Grade, GivesAllForTheComponentAndItsValue) {
  EXPECT_DOUBLE_EQ(Of(Says("R1", 60.0)).points, 100.0);
  EXPECT_DOUBLE_EQ(Of(Says("R1", 62.5)).points, 100.0) << "within 5 %";
  EXPECT_NEAR(Of(Says("R1", 60.0)).bound, 0.01, 1e-12);
}

TEST(Grade, TakesPointsOffForEachDayThatALateAnswerHasBegun) {
  Rubric rubric;
  rubric.late_percent_a_day = 30.0;
  const auto late = [&](double hours) {
    return GradeAnswer(
        Says("R1", 60.0), std::vector<core::Fault>{kFault}, Diagnosed(), rubric, hours, 20.0);
  };
  EXPECT_DOUBLE_EQ(late(-3.0).points, 100.0) << "in time";
  EXPECT_DOUBLE_EQ(late(0.0).points, 100.0);
  EXPECT_DOUBLE_EQ(late(0.1).points, 70.0);
  EXPECT_DOUBLE_EQ(late(24.0).points, 70.0);
  EXPECT_DOUBLE_EQ(late(24.1).points, 40.0);
  EXPECT_DOUBLE_EQ(late(24.1).late_percent, 60.0);
  EXPECT_DOUBLE_EQ(late(1000.0).points, 0.0);
}

TEST(Grade, GivesLessForAWorseValueAndNothingForAUselessOne) {
  const double good = Of(Says("R1", 64.0)).value;
  const double poor = Of(Says("R1", 80.0)).value;
  EXPECT_LT(good, 1.0);
  EXPECT_LT(poor, good);
  EXPECT_GT(poor, 0.0);
  EXPECT_DOUBLE_EQ(Of(Says("R1", 120.0)).points, 70.0);
  EXPECT_DOUBLE_EQ(Of(Says("R1", 30.0)).value, 0.0);
}

TEST(Grade, AsksNoMoreOfAValueThanTheRecordTells) {
  core::Diagnosis diagnosis = Diagnosed();
  diagnosis.verdict.candidates[0].sigma = 12.0;  // 20 %
  const Grade grade = GradeAnswer(
      Says("R1", 90.0), std::vector<core::Fault>{kFault}, diagnosis, Rubric{}, 0.0, 20.0);
  EXPECT_DOUBLE_EQ(grade.value, 1.0);
  EXPECT_NEAR(grade.tolerance, 0.6, 1e-12);
}

TEST(Grade, TakesAComponentThatNobodyCanTellFromTheTrueOne) {
  const Grade grade = Of(Says("C8", 2e-6));
  EXPECT_TRUE(grade.right);
  EXPECT_DOUBLE_EQ(grade.points, 100.0);
  EXPECT_DOUBLE_EQ(Of(Says("C8", 8e-6)).value, 0.0) << "not the value that it would have";
  EXPECT_FALSE(Of(Says("J", 1e-5)).right);
}

TEST(Grade, IsNotHeldAgainstAFaultThatNeverCame) {
  for (const Answer& answer : {Says("R1", 60.0), Says("J", 1e-5), Says(nullptr, 0.0)}) {
    const Grade grade = Of(answer, {kFault}, 8.0);
    EXPECT_TRUE(grade.cut);
    EXPECT_FALSE(grade.right);
    EXPECT_DOUBLE_EQ(grade.points, 0.0) << "stopping at once must not be the best strategy";
  }
  EXPECT_FALSE(Of(Says("R1", 60.0), {kFault}, 8.01).cut);
  EXPECT_FALSE(Of(Says(nullptr, 0.0), {}, 1.0).cut);
}

TEST(Grade, GivesDetectionAloneForAnotherComponent) {
  const Grade grade = Of(Says("J", 1e-5, 0.0));
  EXPECT_DOUBLE_EQ(grade.detection, 1.0);
  EXPECT_DOUBLE_EQ(grade.isolation, 0.0);
  EXPECT_DOUBLE_EQ(grade.points, 30.0) << "20, and 10 for knowing it";
}

TEST(Grade, OfAHealthyRigIsAllOrItsConfidence) {
  EXPECT_DOUBLE_EQ(Of(Says(nullptr, 0.0), {}).points, 100.0);
  EXPECT_DOUBLE_EQ(Of(Says("R1", 60.0), {}).points, 0.0);
  EXPECT_DOUBLE_EQ(Of(Says(nullptr, 0.0)).points, 0.0) << "a missed fault, and sure of it";
}

/// Whoever believes 70 % gets most by saying 70 %.
TEST(Grade, RewardsAnHonestConfidence) {
  const auto expected = [](double said) {
    return 0.7 * Of(Says("R1", 60.0, said)).confidence + 0.3 * Of(Says("J", 1e-5, said)).confidence;
  };
  for (const double said : {0.0, 0.3, 0.5, 0.65, 0.75, 0.9, 1.0}) {
    EXPECT_LT(expected(said), expected(0.7)) << said;
  }
}

TEST(Rubric, RefusesWhatGradesNothing) {
  const auto refusal = [](const std::string& text) {
    const auto rubric = ParseRubric(json::parse(text).as_object());
    return rubric.ok() ? std::string() : rubric.error().field;
  };
  EXPECT_EQ(refusal(R"({"detection":0,"isolation":0,"value":0,"confidence":0})"),
            "/rubric/detection");
  EXPECT_EQ(refusal(R"({"full_within":0.5,"none_beyond":0.2})"), "/rubric/none_beyond");
  EXPECT_EQ(refusal(R"({"weight":1})"), "/rubric/weight");
  EXPECT_EQ(refusal(json::serialize(ToJson(Rubric{}))), "");
}

std::string AnswerRefusal(const std::string& text) {
  const auto answer = ParseAnswer(json::parse(text).as_object(), paper::Bench());
  return answer.ok() ? "" : answer.error().field + " " + answer.error().reason;
}

TEST(Answer, RefusesByName) {
  EXPECT_EQ(AnswerRefusal(R"({"component":"R1","value":56,"unit":"ohm","confidence":0.5})"), "");
  EXPECT_EQ(AnswerRefusal(R"({"component":null,"confidence":0.5})"), "");
  EXPECT_EQ(AnswerRefusal(R"({"confidence":0.5})"), "/component member_missing");
  EXPECT_EQ(AnswerRefusal(R"({"component":"R1","value":56,"unit":"kohm","confidence":1})"),
            "/unit unit_wrong");
  EXPECT_EQ(AnswerRefusal(R"({"component":"R1","value":-1,"unit":"ohm","confidence":1})"),
            "/value number_outside");
  EXPECT_EQ(AnswerRefusal(R"({"component":"Q7","value":1,"unit":"ohm","confidence":1})"),
            "/component no_component");
  EXPECT_EQ(AnswerRefusal(R"({"component":null,"value":1,"confidence":1})"),
            "/value member_unknown");
  EXPECT_EQ(AnswerRefusal(R"({"component":"R1","value":56,"unit":"ohm","confidence":90})"),
            "/confidence number_outside");
}

}  // namespace
}  // namespace faultlab::server::course
