#pragma once

#include <array>
#include <boost/json/object.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/bench/bench.h"
#include "core/diagnosis/diagnosis.h"
#include "core/types/component.h"
#include "core/types/fault.h"
#include "server/storage/recording_store.h"

// What happened in a run and what is known of it, told once: page, lists, figures, report and
// REST show this, and none of them decides anything.
namespace faultlab::server {

/// A component has another value since `at_s`: the rig has confirmed it.
struct RigChange {
  double at_s = 0.0;
  core::Component component{};
  double value = 0.0;   ///< SI
  double before = 0.0;  ///< its value until then
  bool nominal = false;
  std::vector<core::Component> others;  ///< that were not nominal then
};

/// One alarm.
struct StoryDetection {
  /// A return is an alarm after its component was set back.
  enum class Of { kFirst, kFurther, kReturn };

  double at_s = 0.0;
  std::optional<double> delay_s;     ///< since the newest change that the rig has confirmed before
  std::optional<double> isolated_s;  ///< when something was named first
  std::vector<core::Component> named;  ///< at last, by events; the episode's `found` may know more
  Of of = Of::kFirst;
};

/// A stretch in which the rig is not nominal. It belongs to one component: a change of another one
/// begins the next.
struct StoryEpisode {
  std::vector<RigChange> changes;  ///< in time order; empty when no rig has reported one
  std::vector<StoryDetection> detections;
  double onset_s = 0.0;  ///< its first change, else as the diagnosis estimates, else its alarm
  std::optional<double> ended_s;
  std::optional<core::FaultEpisode> found;  ///< what the diagnosis says of it

  /// Since when the values that were found hold.
  double since_s() const;
};

struct RunStory {
  std::vector<StoryEpisode> episodes;  ///< in time order
  std::vector<RigChange> changes;      ///< all, those back to nominal too
  bool set_back = false;  ///< the rig is healthy at last, and something was found in it before

  /// When something changed, in order: for each, the estimators' windows hold samples from before
  /// it.
  std::vector<double> ChangeTimes() const;
  /// What was found, in the order of the episodes.
  std::vector<core::FaultEpisode> Found() const;
};

/// Of an event, what a story needs.
struct StoryEvent {
  enum class Kind { kCommanded, kConfirmed, kTrip, kDetected, kIsolated, kReturned, kLearning };

  Kind kind = Kind::kConfirmed;
  std::int64_t index = 0;
  core::Component component{};
  double value = 0.0;
  std::vector<core::Component> named{};  ///< of kIsolated
};
/// By StoryEvent::Kind; events of other kinds are no part of any story.
inline constexpr std::array<std::string_view, 7> kStoryEventKinds = {
    "fault_commanded", "relay_confirmed", "trip", "detected", "isolated", "returned", "learning"};
std::optional<StoryEvent> ToStoryEvent(const RecordedEvent& event, const core::Bench& bench);

/// @param events     in any order
/// @param diagnosis  so far, or of the whole
/// Errors: none; what is missing is not told.
RunStory TellStory(std::vector<StoryEvent> events,
                   const core::Diagnosis& diagnosis,
                   double period_s);
RunStory TellStory(std::span<const RecordedEvent> events,
                   const core::Diagnosis& diagnosis,
                   const core::Bench& bench,
                   double period_s);

/// Of a story, so much is told: the newest.
inline constexpr std::size_t kStoryMost = 500;
inline constexpr std::size_t kStoryInListMost = 8;
/// A viewer that reads slowly is cut off at 512 kB: some 15 kB of each message.
inline constexpr std::size_t kStoryLiveMost = 40;
/// {"episodes":[{"onset_s","since_s","ended_s","changes","detections":[{"detected_at_s","delay_s",
/// "isolated_at_s","named","of"}],"finding"}],"changes":[{"component","value","before","at_s",
/// "nominal","others"}],"change_times_s","set_back"}: the newest `most` of each.
boost::json::object ToJson(const RunStory& story, std::size_t most = kStoryMost);
std::string StoryText(const RunStory& story, std::size_t most = kStoryMost);

/// For figures: a drift, which no rig confirms value by value, is as it was planned. As planned
/// altogether when the rig has reported nothing.
std::vector<core::Fault> FaultsToShow(std::span<const RigChange> changes,
                                      std::vector<core::Fault> planned);

}  // namespace faultlab::server
