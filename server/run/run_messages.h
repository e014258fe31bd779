#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/frame.h"
#include "core/types/plant_parameters.h"
#include "core/types/verdict.h"
#include "hardware/rig.h"
#include "server/run/waiting_changes.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

/// {"type":"event","kind","index","t_s","component"?,"value"?,"text"?,"loop"?}
/// @param loop  of the whole run, with its last event; may be null
RecordedEvent MakeEvent(const hardware::RigEvent& event,
                        double period_s,
                        const hardware::LoopQuality* loop = nullptr);
/// An event of the diagnosis: "learnt", "not_learnt", "detected", "isolated", "returned".
RecordedEvent MakeDiagnosisEvent(std::string_view kind,
                                 std::int64_t index,
                                 double period_s,
                                 std::string_view text);
/// "isolated": all that the verdict names, in the order of the bench; a component of its own and
/// its value where that is one alone.
RecordedEvent MakeIsolationEvent(const core::Verdict& verdict, std::int64_t index, double period_s);
/// "learning": the healthy rig is learnt anew, until the run time `until_s`, which is its value.
RecordedEvent MakeLearningEvent(std::int64_t index, double until_s, double period_s);
/// An event of a change that waits, or waited, for the end of the calibration.
RecordedEvent MakeChangeEvent(const ChangeNote& note, std::int64_t index, double period_s);
/// "rig_silent", or "rig_heard" with the length of the silence as its value.
RecordedEvent MakeLinkEvent(std::string_view kind,
                            std::int64_t index,
                            double period_s,
                            std::optional<double> silent_s);
/// "rest_fetched": `samples` from `index` on were read from the rig after its server had died.
RecordedEvent MakeRestEvent(std::int64_t index, std::int64_t samples, double period_s);
/// Back from a recording. nullopt for events that no rig said.
std::optional<hardware::RigEvent> ToRigEvent(const RecordedEvent& event, const core::Bench& bench);

/// {"type":"readout","index","estimators":[{"name","theta","sigma","condition","status","age"}]}
std::string ReadoutText(const core::Frame& frame);

/// {"type":"verdict", ..verdict object}
std::string VerdictText(const core::Verdict& verdict);

/// {"type":"end","state":..}
std::string EndText(RunState state);

/// Value and state of each component, as the rig has confirmed it.
struct ComponentPosition {
  double value = 0.0;
  std::string_view state = "confirmed";  ///< "commanded" | "confirmed" | "refused"
};
using Positions = std::map<core::Component, ComponentPosition, core::ByIndex>;
Positions NominalPositions(const core::Bench& bench, const core::PlantParameters& nominal);
void Follow(Positions& positions, const hardware::RigEvent& event, const Positions& nominal);

/// Members of `hello` that the run knows, without braces.
struct HelloParts {
  std::string_view run;
  std::string_view bench;  ///< core::Bench::id
  RunState state = RunState::kRunning;
  hardware::Epoch epoch{};
  double rate_hz = 100.0;
  std::string_view plan_json;
  const Positions& positions;
  const std::vector<RecordedEvent>& events;
  std::string_view verdict_text;           ///< of VerdictText
  std::string_view story_text;             ///< of StoryText
  std::optional<double> learning_until_s;  ///< end of the calibration stretch
  WaitingChanges::Values waiting;          ///< changes that wait for this end
  core::PlantParameters nominal;
  double delta_s = 0.0;
};
std::string HelloMembers(const HelloParts& parts);

}  // namespace faultlab::server
