#include "server/run/run_messages.h"

#include <boost/json.hpp>

#include "core/plant/coefficients.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/json/kept_json.h"
#include "server/json/number_or_null.h"
#include "server/run/loop_json.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using hardware::NamesComponent;
using hardware::RigEventKind;

bool HasValue(RigEventKind kind) {
  return NamesComponent(kind) || kind == RigEventKind::kTrip || kind == RigEventKind::kOverrun ||
         kind == RigEventKind::kDeltaStrays || kind == RigEventKind::kGap;
}

json::object EventObject(std::string_view kind, std::int64_t index, double period_s) {
  return {{"type", "event"},
          {"kind", kind},
          {"index", index},
          {"t_s", static_cast<double>(index) * period_s}};
}

RecordedEvent Recorded(std::string_view kind, std::int64_t index, const json::object& object) {
  return {index, std::string(kind), json::serialize(object)};
}

}  // namespace

RecordedEvent MakeEvent(const hardware::RigEvent& event,
                        double period_s,
                        const hardware::LoopQuality* loop) {
  json::object object = EventObject(hardware::Name(event.kind), event.index, period_s);
  if (NamesComponent(event.kind) && event.component.exists()) {
    object["component"] = core::Name(event.component);
  }
  if (HasValue(event.kind)) object["value"] = NumberOrNull(event.value);
  if (!event.text.empty()) object["text"] = event.text;
  if (loop != nullptr) object["loop"] = ToJson(*loop);
  return Recorded(hardware::Name(event.kind), event.index, object);
}

RecordedEvent MakeDiagnosisEvent(std::string_view kind,
                                 std::int64_t index,
                                 double period_s,
                                 std::string_view text) {
  json::object object = EventObject(kind, index, period_s);
  if (!text.empty()) object["text"] = text;
  return Recorded(kind, index, object);
}

RecordedEvent MakeIsolationEvent(const core::Verdict& verdict,
                                 std::int64_t index,
                                 double period_s) {
  constexpr std::string_view kKind = "isolated";
  json::object object = EventObject(kKind, index, period_s);
  json::array components = ComponentNames(core::NamedBy(verdict));
  if (components.size() == 1) {
    object["component"] = components.front();
    object["value"] = NumberOrNull(verdict.candidates.front().value);
  }
  object["components"] = std::move(components);
  object["text"] = verdict.reason;
  return Recorded(kKind, index, object);
}

RecordedEvent MakeChangeEvent(const ChangeNote& note, std::int64_t index, double period_s) {
  json::object object = EventObject(note.kind, index, period_s);
  object["component"] = core::Name(note.component);
  object["value"] = NumberOrNull(note.value);
  if (!note.text.empty()) object["text"] = note.text;
  if (!note.reason.empty()) object["reason"] = note.reason;
  if (!note.parameters.empty()) {
    json::object parameters;
    for (const core::ErrorParameter& each : note.parameters) parameters[each.name] = each.value;
    object["parameters"] = std::move(parameters);
  }
  return Recorded(note.kind, index, object);
}

RecordedEvent MakeLinkEvent(std::string_view kind,
                            std::int64_t index,
                            double period_s,
                            std::optional<double> silent_s) {
  json::object object = EventObject(kind, index, period_s);
  if (silent_s) object["value"] = NumberOrNull(*silent_s);
  return Recorded(kind, index, object);
}

RecordedEvent MakeLearningEvent(std::int64_t index, double until_s, double period_s) {
  constexpr std::string_view kKind = "learning";
  json::object object = EventObject(kKind, index, period_s);
  object["value"] = until_s;
  return Recorded(kKind, index, object);
}

RecordedEvent MakeRestEvent(std::int64_t index, std::int64_t samples, double period_s) {
  constexpr std::string_view kKind = "rest_fetched";
  json::object object = EventObject(kKind, index, period_s);
  object["value"] = samples;
  object["text"] = "read from the rig after the server had ended without a word";
  return Recorded(kKind, index, object);
}

std::optional<hardware::RigEvent> ToRigEvent(const RecordedEvent& recorded,
                                             const core::Bench& bench) {
  const auto kind = hardware::ParseRigEventKind(recorded.kind);
  if (!kind) return std::nullopt;
  const json::value parsed = ParsedOr(recorded.json);
  if (!parsed.is_object()) return std::nullopt;
  hardware::RigEvent event;
  event.kind = *kind;
  event.index = recorded.index;
  if (const auto* value = MemberIn(parsed, "value"); value != nullptr && value->is_number()) {
    event.value = value->to_number<double>();
  }
  event.text = TextIn(parsed, "text");
  if (const auto component = bench.Find(TextIn(parsed, "component"))) event.component = *component;
  return event;
}

std::string ReadoutText(const core::Frame& frame) {
  json::array estimators;
  for (std::size_t i = 0; i < frame.estimates.size(); ++i) {
    const core::Estimate<3> estimate = core::Shown(frame.estimates[i]);
    const bool known = estimate.status != core::EstimateStatus::kInvalid;
    json::object entry;
    entry["name"] = core::kEstimatorShapes[i].name;
    entry["theta"] = known ? json::value(NumbersOrNull(estimate.theta)) : json::value(nullptr);
    entry["sigma"] = known ? json::value(NumbersOrNull(estimate.sigma)) : json::value(nullptr);
    entry["condition"] = known ? NumberOrNull(estimate.condition) : json::value(nullptr);
    entry["status"] = core::Name(estimate.status);
    entry["age"] = estimate.age_samples;
    estimators.push_back(std::move(entry));
  }
  return json::serialize(json::object{
      {"type", "readout"}, {"index", frame.sample.index}, {"estimators", std::move(estimators)}});
}

std::string VerdictText(const core::Verdict& verdict) {
  json::object object = ToJson(verdict);
  object["type"] = "verdict";
  return json::serialize(object);
}

std::string EndText(RunState state) {
  return json::serialize(json::object{{"type", "end"}, {"state", Name(state)}});
}

Positions NominalPositions(const core::Bench& bench, const core::PlantParameters& nominal) {
  Positions positions;
  for (const core::Component component : bench.components()) {
    positions[component] = {nominal.Get(component), "confirmed"};
  }
  return positions;
}

void Follow(Positions& positions, const hardware::RigEvent& event, const Positions& nominal) {
  // An event of a component that this program does not know.
  if (NamesComponent(event.kind) && !event.component.exists()) return;
  switch (event.kind) {
    case RigEventKind::kFaultCommanded:
      positions[event.component].state = "commanded";
      break;
    case RigEventKind::kRelayConfirmed:
      positions[event.component] = {event.value, "confirmed"};
      break;
    case RigEventKind::kRefused:
      positions[event.component].state = "refused";
      break;
    case RigEventKind::kTrip:
    case RigEventKind::kStopped:
    case RigEventKind::kFinished:
      positions = nominal;  // every way out leaves the relays nominal
      break;
    default:
      break;
  }
}

std::string HelloMembers(const HelloParts& parts) {
  json::object object;
  object["run"] = parts.run;
  object["state"] = Name(parts.state);
  object["bench"] = parts.bench;
  object["epoch"] = static_cast<std::uint64_t>(parts.epoch);
  object["rate_hz"] = parts.rate_hz;
  json::object positions;
  for (const auto& [component, position] : parts.positions) {
    positions[core::Name(component)] =
        json::object{{"value", position.value}, {"state", position.state}};
  }
  object["positions"] = std::move(positions);
  object["learning_until_s"] =
      parts.learning_until_s ? json::value(*parts.learning_until_s) : json::value(nullptr);
  json::object waiting;
  for (const auto& [component, value] : parts.waiting) waiting[core::Name(component)] = value;
  object["waiting"] = std::move(waiting);
  const core::ContinuousCoefficients continuous = core::MakeContinuous(parts.nominal);
  const core::DiscreteCoefficients discrete =
      core::Discretise(continuous, 1.0 / parts.rate_hz, parts.delta_s);
  object["nominal"] =
      json::object{{"swa", json::array{discrete.b0d, discrete.b1d, discrete.a1d}},
                   {"sia", json::array{continuous.b0, continuous.b1, continuous.a1}}};
  std::string text = json::serialize(object);
  // Plan, events and verdict are already JSON text.
  std::string out = text.substr(1, text.size() - 2);
  out.append(",\"plan\":").append(parts.plan_json.empty() ? "{}" : parts.plan_json);
  out.append(",\"events\":[");
  for (std::size_t i = 0; i < parts.events.size(); ++i) {
    if (i > 0) out.push_back(',');
    out.append(parts.events[i].json);
  }
  out.append("],\"verdict\":").append(parts.verdict_text.empty() ? "null" : parts.verdict_text);
  out.append(",\"story\":").append(parts.story_text);
  return out;
}

}  // namespace faultlab::server
