#include "server/diagnosis_json/diagnosis_json.h"

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <string>

#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

/// R1 has changed three times: the second and the third alarm belong to the fault of the first.
core::Diagnosis ChangedThreeTimes() {
  core::Diagnosis diagnosis;
  core::Verdict& verdict = diagnosis.verdict;
  verdict.kind = core::VerdictKind::kFault;
  verdict.detected_at_s = 8.02;
  verdict.onset_s = 7.99;
  verdict.detector = "residual";
  verdict.further = {{14.04, 13.98, "cusum"}, {17.06, std::nullopt, "glr_50"}};
  verdict.group = {paper::kR1};
  verdict.candidates = {{paper::kR1, 33.0, 0.5, 0, 1.0, 0.0}};
  verdict.settled = true;
  diagnosis.episodes = {{verdict, core::FaultShape::kAbrupt, 19.5}};
  return diagnosis;
}

json::object Written(const core::Diagnosis& diagnosis) {
  return ToJson(diagnosis, paper::Bench());
}

core::Diagnosis ReadBack(const json::object& document) {
  auto read = ParseDiagnosis(json::serialize(document), paper::Bench());
  EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().field + ": " + read.error().message);
  return read.ok() ? std::move(read).value() : core::Diagnosis{};
}

void ExpectFurther(const core::Verdict& verdict) {
  EXPECT_EQ(verdict.detected_at_s, 8.02);
  EXPECT_EQ(verdict.onset_s, 7.99);
  EXPECT_EQ(verdict.detector, "residual");
  ASSERT_EQ(verdict.further.size(), 2U);
  EXPECT_EQ(verdict.further[0].detected_at_s, 14.04);
  EXPECT_EQ(verdict.further[0].onset_s, 13.98);
  EXPECT_EQ(verdict.further[0].detector, "cusum");
  EXPECT_EQ(verdict.further[1].detected_at_s, 17.06);
  EXPECT_EQ(verdict.further[1].onset_s, std::nullopt);
  EXPECT_EQ(verdict.further[1].detector, "glr_50");
}

TEST(DiagnosisJson, EveryDetectionOfAFaultComesBack) {
  const core::Diagnosis read = ReadBack(Written(ChangedThreeTimes()));
  ExpectFurther(read.verdict);
  ASSERT_EQ(read.episodes.size(), 1U);
  ExpectFurther(read.episodes[0].verdict);
  EXPECT_EQ(read.episodes[0].ended_at_s, 19.5);
}

TEST(DiagnosisJson, ADiagnosisStoredBeforeFurtherDetectionsWereKeptIsRead) {
  json::object stored = Written(ChangedThreeTimes());
  ASSERT_EQ(stored.erase("further"), 1U);
  ASSERT_EQ(stored.at("episodes").at(0).as_object().erase("further"), 1U);
  const core::Diagnosis read = ReadBack(stored);
  EXPECT_EQ(read.verdict.detected_at_s, 8.02);
  EXPECT_TRUE(read.verdict.further.empty());
  ASSERT_EQ(read.episodes.size(), 1U);
  EXPECT_TRUE(read.episodes[0].verdict.further.empty());
}

TEST(DiagnosisJson, ADiagnosisStoredBeforeCertaintyWasKeptTellsNone) {
  core::Diagnosis sure = ChangedThreeTimes();
  sure.verdict.candidates[0].probability = 0.97;
  json::object stored = Written(sure);
  EXPECT_EQ(ReadBack(stored).verdict.candidates.at(0).probability, 0.97);
  EXPECT_NE(ToText(ReadBack(stored), "a.csv").find("97 %"), std::string::npos);

  stored.at("candidates").at(0).as_object().erase("probability");
  const core::Diagnosis old = ReadBack(stored);
  EXPECT_TRUE(Written(old).at("candidates").at(0).at("probability").is_null());
  EXPECT_EQ(ToText(old, "a.csv").find("certainty"), std::string::npos);
}

TEST(DiagnosisJson, AFaultThatChangedOnceHasTheFormerForm) {
  core::Diagnosis once = ChangedThreeTimes();
  once.verdict.further.clear();
  EXPECT_FALSE(Written(once).contains("further"));
}

TEST(DiagnosisJson, AFurtherDetectionWithoutATimeIsRefused) {
  json::object stored = Written(ChangedThreeTimes());
  stored.at("further").at(0).as_object()["detected_at_s"] = "soon";
  EXPECT_FALSE(ParseDiagnosis(json::serialize(stored), paper::Bench()).ok());
}

TEST(DiagnosisJson, ThePathNamesItsComponentsAndHowItsEndCompares) {
  core::Diagnosis diagnosis = ChangedThreeTimes();
  EXPECT_FALSE(Written(diagnosis).contains("path_outcome")) << "there is no path";
  diagnosis.verdict.path = {
      {"a1 outside its band?", false, 0.01, 0.02, "b0", {}},
      {"b0 outside its band?", true, 0.03, 0.01, "R9 or R12", {paper::kR9, paper::kR12}}};
  json::object written = Written(diagnosis);
  EXPECT_EQ(written.at("path_outcome"), "window");
  EXPECT_EQ(written.at("path").at(0).at("close"), false) << "a factor of two is not close";
  EXPECT_EQ(written.at("path").at(1).at("components"), (json::array{"R9", "R12"}));
  const auto ends = [](const core::Diagnosis& read) { return read.verdict.path.back().components; };
  EXPECT_EQ(ends(ReadBack(written)), (std::vector{paper::kR9, paper::kR12}));

  // As it was stored before a step had members for them.
  written.erase("path_outcome");
  for (json::value& step : written.at("path").as_array()) {
    step.as_object().erase("components");
    step.as_object().erase("close");
  }
  written.at("path").at(1).as_object()["leads_to"] = "C8, Ra or J";
  EXPECT_EQ(ends(ReadBack(written)), (std::vector{paper::kC8, paper::kRa, paper::kJ}));
  written.at("path").at(1).as_object()["leads_to"] = "no component";
  EXPECT_TRUE(ends(ReadBack(written)).empty());
}

TEST(DiagnosisJson, AChangedSensorComesBack) {
  core::Diagnosis diagnosis = ChangedThreeTimes();
  EXPECT_FALSE(Written(diagnosis).contains("response"));
  diagnosis.verdict.response = core::ResponseChange{
      {{54.0, 0.1}, {0.06, 1e-3}, {14.0, 0.5}}, {{71.0, core::kAbsent}, {0.1, 2e-3}, {20.0, 1.0}}};
  const core::Diagnosis with_response = ReadBack(Written(diagnosis));
  ASSERT_TRUE(with_response.verdict.response);
  EXPECT_EQ(with_response.verdict.response->before.time_constant.sigma, 1e-3);
  EXPECT_EQ(with_response.verdict.response->after.gain.value, 71.0);
  EXPECT_TRUE(std::isnan(with_response.verdict.response->after.gain.sigma));
  EXPECT_EQ(with_response.verdict.response->after.friction.sigma, 1.0);
  EXPECT_FALSE(Written(diagnosis).contains("sensor"));
  diagnosis.verdict.sensor = core::SensorChange{"n", core::SensorChange::Kind::kGain, 1.05, 0.001};
  const core::Diagnosis read = ReadBack(Written(diagnosis));
  ASSERT_TRUE(read.verdict.sensor);
  EXPECT_EQ(read.verdict.sensor->channel, "n");
  EXPECT_EQ(read.verdict.sensor->kind, core::SensorChange::Kind::kGain);
  EXPECT_EQ(read.verdict.sensor->value, 1.05);
  EXPECT_EQ(read.verdict.sensor->sigma, 0.001);
  EXPECT_FALSE(read.verdict.friction);
}

TEST(DiagnosisJson, FrictionThatHasGrownComesBack) {
  core::Diagnosis diagnosis = ChangedThreeTimes();
  diagnosis.verdict.friction = core::FrictionChange{0.33e-3, 0.99e-3, 0.02e-3};
  const core::Diagnosis read = ReadBack(Written(diagnosis));
  ASSERT_TRUE(read.verdict.friction);
  EXPECT_EQ(read.verdict.friction->before_nm, 0.33e-3);
  EXPECT_EQ(read.verdict.friction->after_nm, 0.99e-3);
  EXPECT_EQ(read.verdict.friction->sigma_nm, 0.02e-3);
}

TEST(DiagnosisText, TellsEveryDetectionOfAFault) {
  const std::string text = ToText(ChangedThreeTimes(), "run.csv");
  EXPECT_NE(text.find("  detected    at 8.02 s, began at about 7.99 s (residual)\n"
                      "  again       at 14.04 s, began at about 13.98 s (cusum)\n"
                      "  again       at 17.06 s (glr_50)\n"),
            std::string::npos)
      << text;
}

TEST(DiagnosisText, TellsTheFurtherDetectionsOfAnEarlierFault) {
  core::Diagnosis diagnosis = ChangedThreeTimes();
  core::FaultEpisode last = diagnosis.episodes[0];
  last.verdict.detected_at_s = 25.0;
  last.verdict.further.clear();
  last.ended_at_s.reset();
  diagnosis.episodes.push_back(last);
  const std::string text = ToText(diagnosis, "run.csv");
  EXPECT_NE(text.find("8.02 s: fault R1, again 14.04 s, again 17.06 s, until 19.50 s\n"),
            std::string::npos)
      << text;
}

}  // namespace
}  // namespace faultlab::server
