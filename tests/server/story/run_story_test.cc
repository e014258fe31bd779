#include "server/story/run_story.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <cmath>
#include <string>

#include "tests/paper_bench.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using paper::kJ;
using paper::kPeriodS;
using paper::kR1;
using paper::kR12;
using paper::kR9;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Of = StoryDetection::Of;

constexpr double kSameS = 1e-9;

RecordedEvent Event(const char* kind, double at_s) {
  RecordedEvent event;
  event.index = std::llround(at_s / kPeriodS);
  event.kind = kind;
  event.json = "{}";
  return event;
}

RecordedEvent Told(const char* kind, core::Component component, double value, double at_s) {
  RecordedEvent event = Event(kind, at_s);
  event.json =
      json::serialize(json::object{{"component", core::Name(component)}, {"value", value}});
  return event;
}

RecordedEvent Confirmed(core::Component component, double value, double at_s) {
  return Told("relay_confirmed", component, value, at_s);
}

core::FaultEpisode Found(std::vector<core::Component> group,
                         double detected_at_s,
                         std::optional<double> ended_at_s = {}) {
  core::FaultEpisode found;
  found.verdict.kind = core::VerdictKind::kFault;
  found.verdict.detected_at_s = detected_at_s;
  found.verdict.onset_s = detected_at_s;
  for (const core::Component component : group) {
    found.verdict.candidates.push_back({component, 56.0, 1.0, 0, 1.0, 0.0});
  }
  found.verdict.candidates.push_back({kJ, 3e-5, 1e-7, 0, 4.0, 3.0});  // the runner-up
  found.verdict.group = std::move(group);
  found.ended_at_s = ended_at_s;
  return found;
}

RunStory Tell(const std::vector<RecordedEvent>& events,
              std::vector<core::FaultEpisode> found = {}) {
  core::Diagnosis diagnosis;
  diagnosis.episodes = std::move(found);
  if (!diagnosis.episodes.empty()) diagnosis.verdict = diagnosis.episodes.back().verdict;
  return TellStory(events, diagnosis, paper::Bench(), kPeriodS);
}

std::vector<Of> KindsOf(const StoryEpisode& episode) {
  std::vector<Of> kinds;
  for (const StoryDetection& each : episode.detections) kinds.push_back(each.of);
  return kinds;
}

double Nominal(core::Component component) {
  return component.info().nominal;
}

TEST(RunStory, OfAHealthyRunIsEmpty) {
  const RunStory story = Tell({Confirmed(kR1, Nominal(kR1), 3.0)});
  EXPECT_THAT(story.episodes, IsEmpty());
  EXPECT_THAT(story.changes, IsEmpty());
}

TEST(RunStory, HasOneEpisodeOfAComponentThatWasChangedTwice) {
  const RunStory story = Tell({Confirmed(kR1, 100.0, 10.0),
                               Event("detected", 10.0),
                               Event("isolated", 10.26),
                               Confirmed(kR1, 220.0, 18.0),
                               Event("isolated", 18.3),
                               Event("detected", 18.02)},  // it is told late
                              {Found({kR1}, 10.0)});
  ASSERT_EQ(story.episodes.size(), 1U);
  const StoryEpisode& episode = story.episodes.front();
  EXPECT_EQ(episode.onset_s, 10.0);
  ASSERT_EQ(episode.changes.size(), 2U);
  EXPECT_EQ(episode.changes[0].before, Nominal(kR1));
  EXPECT_EQ(episode.changes[1].before, 100.0);
  EXPECT_THAT(KindsOf(episode), ElementsAre(Of::kFirst, Of::kFurther));
  EXPECT_NEAR(*episode.detections[1].delay_s, 0.02, kSameS);
  EXPECT_NEAR(*episode.detections[0].isolated_s, 10.26, kSameS);
  EXPECT_NEAR(*episode.detections[1].isolated_s, 18.3, kSameS);
  EXPECT_THAT(story.ChangeTimes(), ElementsAre(DoubleNear(10, kSameS), DoubleNear(18, kSameS)));
}

TEST(RunStory, EndsAnEpisodeWhenThePartIsNominalAgain) {
  const RunStory story = Tell({Confirmed(kR1, 100.0, 8.0),
                               Event("detected", 8.0),
                               Confirmed(kR1, Nominal(kR1), 14.0),
                               Event("detected", 14.0),
                               Event("returned", 15.01),
                               Confirmed(kR12, 5600.0, 20.0),
                               Event("detected", 20.0)},
                              {Found({kR1}, 8.0, 14.0), Found({kR9, kR12}, 20.0)});
  ASSERT_EQ(story.episodes.size(), 2U);
  EXPECT_EQ(story.episodes[0].ended_s, 14.0);
  EXPECT_THAT(KindsOf(story.episodes[0]), ElementsAre(Of::kFirst, Of::kReturn));
  EXPECT_EQ(story.episodes[1].ended_s, std::nullopt);
  EXPECT_THAT(story.episodes[1].found->verdict.group, ElementsAre(kR9, kR12));
}

TEST(RunStory, KeepsAReturnThatIsBeingWorkedOutApartFromWhatWasFoundBefore) {
  core::FaultEpisode unclear = Found({}, 14.0);
  unclear.verdict.candidates.clear();
  const RunStory story = Tell({Confirmed(kR1, 100.0, 8.0),
                               Event("detected", 8.0),
                               Confirmed(kR1, Nominal(kR1), 14.0),
                               Event("detected", 14.0)},
                              {Found({kR1}, 8.0, 14.0), unclear});
  ASSERT_EQ(story.episodes.size(), 1U);
  EXPECT_THAT(story.episodes[0].found->verdict.group, ElementsAre(kR1));
}

TEST(RunStory, GivesASecondComponentAnEpisodeOfItsOwn) {
  const RunStory story = Tell({Confirmed(kR1, 100.0, 8.0), Confirmed(kR12, 5600.0, 12.0)});
  EXPECT_EQ(story.episodes.size(), 2U);
  EXPECT_THAT(story.changes[1].others, ElementsAre(kR1));
}

TEST(RunStory, AnInterlockSetsAllBack) {
  const RunStory story =
      Tell({Confirmed(kR1, 100.0, 8.0), Confirmed(kR12, 5600.0, 9.0), Event("trip", 11.0)});
  ASSERT_EQ(story.changes.size(), 4U);
  EXPECT_TRUE(story.changes[2].nominal && story.changes[3].nominal);
  for (const StoryEpisode& each : story.episodes) EXPECT_EQ(each.ended_s, 11.0);
}

TEST(RunStory, ADriftIsOneEpisodeFromItsAlarmOn) {
  const std::vector<RecordedEvent> drift = {Told("fault_commanded", kR1, 10.0, 10.0),
                                            Event("detected", 10.5),
                                            Confirmed(kR1, 10.0, 20.0),
                                            Told("fault_commanded", kR1, 1.0, 35.0),
                                            Confirmed(kR1, Nominal(kR1), 35.0),
                                            Event("detected", 35.0),
                                            Event("returned", 36.0)};
  const RunStory story = Tell(drift, {Found({kR1}, 10.5, 35.0)});
  ASSERT_EQ(story.episodes.size(), 1U);
  EXPECT_THAT(KindsOf(story.episodes[0]), ElementsAre(Of::kFirst, Of::kReturn));
  std::vector<RecordedEvent> with_another = drift;
  with_another.insert(with_another.begin(), Event("detected", 8.0));
  with_another.erase(with_another.begin() + 2);
  EXPECT_EQ(Tell(with_another).episodes.size(), 2U) << "that alarm was before it began to drift";
}

TEST(RunStory, IsToldByTheDiagnosisAloneWhereNoRigReports) {
  core::FaultEpisode first = Found({kR1}, 7.3, 12.0);
  first.verdict.onset_s = 7.1;
  core::FaultEpisode second = Found({kR12}, 14.0);
  second.verdict.further = {{16.03, 16.0, "residual"}, {18.0, std::nullopt, "cusum"}};
  const RunStory story = Tell({}, {first, second});
  ASSERT_EQ(story.episodes.size(), 2U) << "each has its own";
  EXPECT_EQ(story.episodes[0].onset_s, 7.1);
  EXPECT_EQ(story.episodes[0].ended_s, 12.0);
  EXPECT_EQ(story.episodes[0].since_s(), 7.1);
  EXPECT_THAT(KindsOf(story.episodes[1]), ElementsAre(Of::kFirst, Of::kFurther, Of::kFurther));
  EXPECT_EQ(story.episodes[1].since_s(), 18.0);
  EXPECT_THAT(story.ChangeTimes(), ElementsAre(7.1, 14.0, 16.0, 18.0));
}

TEST(RunStory, AReturnThatIsToldAfterTheNextChangeEndsNotThat) {
  const RunStory story = Tell({Confirmed(kR1, 100.0, 8.0),
                               Event("detected", 8.0),
                               Confirmed(kR1, Nominal(kR1), 10.0),
                               Event("detected", 10.0),
                               Confirmed(kR12, 5600.0, 11.0),
                               Event("returned", 11.01),
                               Event("detected", 11.02)});
  ASSERT_EQ(story.episodes.size(), 2U);
  EXPECT_EQ(story.episodes[0].ended_s, 10.0);
  EXPECT_EQ(story.episodes[1].ended_s, std::nullopt);
  EXPECT_THAT(KindsOf(story.episodes[1]), ElementsAre(Of::kFirst));
}

TEST(RunStory, ASecondFaultOfWhichNoRigTellsHasAnEpisodeOfItsOwn) {
  const std::vector<RecordedEvent> alarms = {Event("detected", 8.0), Event("detected", 14.0)};
  const RunStory told = Tell(alarms, {Found({kR1}, 8.0, 14.0), Found({kR12}, 14.0)});
  ASSERT_EQ(told.episodes.size(), 2U);
  EXPECT_THAT(told.episodes[0].found->verdict.group, ElementsAre(kR1));
  EXPECT_EQ(told.episodes[0].ended_s, 14.0);
  EXPECT_THAT(told.episodes[1].found->verdict.group, ElementsAre(kR12));
  EXPECT_THAT(KindsOf(told.episodes[1]), ElementsAre(Of::kFirst));
  EXPECT_THAT(told.ChangeTimes(), ElementsAre(8.0, 14.0));
  std::vector<RecordedEvent> half = alarms;
  half.insert(half.begin(), Confirmed(kR1, 100.0, 8.0));
  const RunStory mixed = Tell(half, {Found({kR1}, 8.0, 14.0), Found({kR12}, 14.0)});
  ASSERT_EQ(mixed.episodes.size(), 2U);
  EXPECT_EQ(mixed.episodes[0].ended_s, std::nullopt) << "the rig says that it goes on";
  EXPECT_THAT(mixed.episodes[0].found->verdict.group, ElementsAre(kR1));
}

TEST(RunStory, WhatAReturnLeavesIsOfThePartThatIsStillFaulty) {
  const RunStory story =
      Tell({Confirmed(kR1, 100.0, 10.0),
            Event("detected", 10.0),
            Confirmed(kR12, 15e3, 20.0),
            Event("detected", 20.0),
            Confirmed(kR12, Nominal(kR12), 30.0),
            Event("detected", 30.0)},
           {Found({kR1}, 10.0, 20.0), Found({}, 20.0, 30.0), Found({kR1}, 30.0)});
  ASSERT_EQ(story.episodes.size(), 2U);
  EXPECT_EQ(story.episodes[0].found->verdict.detected_at_s, 30.0);
  EXPECT_EQ(story.episodes[0].ended_s, std::nullopt);
}

TEST(RunStory, ALaterAlarmIsNoReturnOfWhatWasNeverNoticedOrHasReturned) {
  const std::vector<RecordedEvent> small = {
      Confirmed(kR1, 1.01, 10.0), Confirmed(kR1, Nominal(kR1), 20.0), Event("detected", 60.0)};
  EXPECT_EQ(Tell(small, {Found({kR12}, 60.0)}).episodes.size(), 2U);
  const std::vector<RecordedEvent> drift = {Confirmed(kR1, 100.0, 10.0),
                                            Event("detected", 10.0),
                                            Confirmed(kR1, Nominal(kR1), 20.0),
                                            Event("returned", 21.0),
                                            Event("detected", 60.0)};
  const RunStory story = Tell(drift, {Found({kR1}, 10.0, 20.0), Found({kR12}, 60.0)});
  ASSERT_EQ(story.episodes.size(), 2U);
  EXPECT_THAT(KindsOf(story.episodes[1]), ElementsAre(Of::kFirst));
}

TEST(RunStory, AnAlarmThatIsWithdrawnEndsNoFaultThatTheRigTellsOf) {
  const RunStory story = Tell({Confirmed(kR1, 1.2, 10.0),
                               Event("detected", 15.0),
                               Event("returned", 17.0),
                               Event("detected", 25.0),
                               Confirmed(kR1, Nominal(kR1), 40.0)},
                              {Found({kR1}, 25.0, 40.0)});
  ASSERT_EQ(story.episodes.size(), 1U);
  EXPECT_EQ(story.episodes[0].ended_s, 40.0);
}

TEST(RunStory, KeepsWhatWasNamedLastAlsoWithoutAFinding) {
  const auto isolated = [](const char* components, double at_s) {
    RecordedEvent event = Event("isolated", at_s);
    event.json = std::string(R"({"components":)") + components + "}";
    return event;
  };
  const RunStory story = Tell({Confirmed(kR12, 15e3, 8.0),
                               Event("detected", 8.0),
                               Confirmed(kR1, 100.0, 8.2),
                               isolated(R"(["R12"])", 8.26),
                               isolated(R"(["R9","R12"])", 9.0)});
  const StoryDetection& alarm = story.episodes.at(0).detections.at(0);
  EXPECT_NEAR(*alarm.isolated_s, 8.26, kSameS) << "although R1 was changed since";
  EXPECT_THAT(alarm.named, ElementsAre(kR9, kR12));
}

TEST(RunStory, AnAlarmThatNothingCameOfStaysInIt) {
  const RunStory story = Tell({Event("detected", 8.0), Event("learning", 9.0)});
  ASSERT_EQ(story.episodes.size(), 1U);
  EXPECT_EQ(story.episodes[0].found, std::nullopt);
  EXPECT_EQ(story.episodes[0].ended_s, 9.0);
}

TEST(RunStory, IsJsonWithWhatIsNamedAndTheNewestOfEach) {
  std::vector<RecordedEvent> events;
  for (int k = 0; k < 12; ++k) {
    events.push_back(Confirmed(kR9, k % 2 == 0 ? 33e3 : Nominal(kR9), 10.0 + k));
  }
  events.push_back(Confirmed(kR9, 33e3, 30.0));
  events.push_back(Event("detected", 30.0));
  const json::object told = ToJson(Tell(events, {Found({kR9, kR12}, 30.0)}), kStoryInListMost);
  EXPECT_EQ(told.at("changes").as_array().size(), kStoryInListMost);
  const json::object& newest = told.at("episodes").as_array().back().as_object();
  EXPECT_EQ(newest.at("onset_s"), 30.0);
  EXPECT_EQ(newest.at("ended_s"), nullptr);
  EXPECT_EQ(newest.at("changes").at(0).at("before"), Nominal(kR9));
  EXPECT_EQ(newest.at("detections").at(0).at("of"), "first");
  const json::object& finding = newest.at("finding").as_object();
  EXPECT_EQ(finding.at("candidates").as_array().size(), 2U) << "all that look alike, no more";
  EXPECT_FALSE(finding.contains("path"));
}

}  // namespace
}  // namespace faultlab::server
