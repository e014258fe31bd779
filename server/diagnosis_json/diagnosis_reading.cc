// Reads a diagnosis from JSON.
#include <algorithm>
#include <boost/json.hpp>

#include "server/diagnosis_json/calibration_json.h"
#include "server/diagnosis_json/diagnosis_json.h"
#include "server/json/document_reader.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;
using core::Error;

double NumberOrAbsent(const json::value& value) {
  return value.is_number() ? value.to_number<double>() : core::kAbsent;
}

std::vector<core::Component> ReadNames(const core::Bench& bench,
                                       const json::array& names,
                                       std::optional<Error>& error) {
  std::vector<core::Component> out;
  for (const json::value& name : names) {
    const auto component =
        name.is_string() ? bench.Find(std::string_view(name.get_string())) : std::nullopt;
    if (component) {
      out.push_back(*component);
    } else if (!error) {
      error = Error{core::ErrorCode::kInvalid, "unknown component", "group", "internal"};
    }
  }
  return out;
}

core::Candidate ReadCandidate(const core::Bench& bench,
                              const json::value& value,
                              std::optional<Error>& error) {
  DocumentReader reader(EntryOf(value), "candidates/", error);
  core::Candidate out;
  const auto component = bench.Find(reader.Text("component"));
  if (component) {
    out.component = *component;
  } else {
    reader.Refuse("component", "unknown component");
  }
  out.value = reader.NumberOrNull("value").value_or(core::kAbsent);
  out.sigma = reader.NumberOrNull("sigma").value_or(core::kAbsent);
  const json::value* bound = EntryOf(value).if_contains("bound");
  if (bound != nullptr && bound->is_string() && !bound->get_string().empty()) {
    out.bound = bound->get_string().front();
  }
  out.score = reader.NumberOrNull("score").value_or(core::kAbsent);
  out.margin = reader.NumberOrNull("margin").value_or(core::kAbsent);
  if (EntryOf(value).contains("probability")) {
    out.probability = reader.NumberOrNull("probability").value_or(core::kAbsent);
  }
  return out;
}

/// "R9, R10 or R12", as paths named components before they had a member for them.
std::vector<core::Component> ComponentsIn(const core::Bench& bench, std::string_view words) {
  std::vector<core::Component> out;
  while (!words.empty()) {
    const std::size_t end = std::min(words.find_first_of(", "), words.size());
    if (const auto component = bench.Find(words.substr(0, end))) out.push_back(*component);
    words.remove_prefix(std::min(end + 1, words.size()));
  }
  return out;
}

core::PathStep ReadStep(const core::Bench& bench,
                        const json::value& value,
                        std::optional<Error>& error) {
  DocumentReader reader(EntryOf(value), "path/", error);
  core::PathStep out;
  out.question = reader.Text("question");
  out.answer = reader.Flag("answer");
  out.value = reader.NumberOrNull("value").value_or(core::kAbsent);
  out.threshold = reader.NumberOrNull("threshold").value_or(core::kAbsent);
  out.leads_to = reader.Text("leads_to");
  out.components = EntryOf(value).contains("components")
                       ? ReadNames(bench, reader.Array("components"), error)
                       : ComponentsIn(bench, out.leads_to);
  return out;
}

core::Detection ReadDetection(const json::value& value, std::optional<Error>& error) {
  DocumentReader reader(EntryOf(value), "further/", error);
  return {
      reader.Number("detected_at_s", 0.0), reader.NumberOrNull("onset_s"), reader.Text("detector")};
}

core::SpeedResponse ReadResponse(const json::object& object, std::optional<core::Error>& error) {
  DocumentReader reader(object, "response/", error);
  const auto measured = [&](std::string_view member) {
    DocumentReader number(reader.Object(member), "response/", error);
    return core::Measured{number.NumberOrNull("value").value_or(core::kAbsent),
                          number.NumberOrNull("sigma").value_or(core::kAbsent)};
  };
  return {measured("gain_rpm_per_v"), measured("time_constant_s"), measured("friction_rpm")};
}

core::Verdict ReadVerdict(const core::Bench& bench,
                          const json::object& object,
                          std::optional<Error>& error) {
  DocumentReader reader(object, "", error);
  core::Verdict out;
  const std::string word = reader.Text("verdict");
  bool known = false;
  for (int i = 0; i <= static_cast<int>(core::VerdictKind::kNotExcited); ++i) {
    if (core::Name(static_cast<core::VerdictKind>(i)) != word) continue;
    out.kind = static_cast<core::VerdictKind>(i);
    known = true;
  }
  if (!known) reader.Refuse("verdict", "unknown word");
  out.detected_at_s = reader.NumberOrNull("detected_at_s");
  out.onset_s = reader.NumberOrNull("onset_s");
  out.detector = reader.Text("detector");
  out.group = ReadNames(bench, reader.Array("group"), error);
  for (const json::value& one : reader.Array("candidates")) {
    out.candidates.push_back(ReadCandidate(bench, one, error));
  }
  for (const json::value& one : reader.Array("path")) {
    out.path.push_back(ReadStep(bench, one, error));
  }
  if (object.contains("further")) {
    for (const json::value& one : reader.Array("further")) {
      out.further.push_back(ReadDetection(one, error));
    }
  }
  if (object.contains("sensor")) {
    DocumentReader sensor(reader.Object("sensor"), "sensor/", error);
    constexpr auto& kKinds = core::SensorChange::kKindNames;
    const auto kind = std::ranges::find(kKinds, sensor.Text("change"));
    if (kind == std::end(kKinds)) sensor.Refuse("change", "unknown word");
    out.sensor =
        core::SensorChange{sensor.Text("channel"),
                           static_cast<core::SensorChange::Kind>(kind - std::begin(kKinds)),
                           sensor.NumberOrNull("value").value_or(core::kAbsent),
                           sensor.NumberOrNull("sigma").value_or(core::kAbsent)};
  }
  if (object.contains("friction")) {
    DocumentReader friction(reader.Object("friction"), "friction/", error);
    const auto number = [&](const char* member) { return friction.Number(member, 0.0); };
    out.friction =
        core::FrictionChange{number("before_nm"), number("after_nm"), number("sigma_nm")};
  }
  if (object.contains("response")) {
    DocumentReader change(reader.Object("response"), "response/", error);
    out.response = core::ResponseChange{ReadResponse(change.Object("before"), error),
                                        ReadResponse(change.Object("after"), error)};
  }
  out.settled = reader.Flag("settled");
  out.reason = reader.Text("reason");
  return out;
}

template <std::size_t N>
void ReadNumbers(const json::array& numbers, std::array<double, N>& out) {
  for (std::size_t i = 0; i < std::min(N, numbers.size()); ++i) out[i] = NumberOrAbsent(numbers[i]);
}

void ReadEstimates(const json::object& object,
                   std::optional<Error>& error,
                   core::Diagnosis& diagnosis) {
  DocumentReader estimators(object, "estimates/", error);
  for (std::size_t i = 0; i < core::kEstimatorCount; ++i) {
    const std::string name(core::kEstimatorShapes[i].name);
    DocumentReader reader(estimators.Object(name), "estimates/" + name + "/", error);
    core::Estimate<3>& estimate = diagnosis.estimates[i];
    ReadNumbers(reader.Array("theta"), estimate.theta);
    ReadNumbers(reader.Array("sigma"), estimate.sigma);
    estimate.condition = reader.NumberOrNull("condition").value_or(core::kAbsent);
    estimate.age_samples = static_cast<std::int32_t>(reader.Number("age", 0.0));
    const std::string word = reader.Text("status");
    for (int s = 0; s <= static_cast<int>(core::EstimateStatus::kInvalid); ++s) {
      const auto status = static_cast<core::EstimateStatus>(s);
      if (core::Name(status) == word) estimate.status = status;
    }
    ReadNumbers(reader.Array("nominal"), diagnosis.nominal_estimates[i]);
  }
}

}  // namespace

core::Result<core::Diagnosis> ParseDiagnosis(std::string_view text, const core::Bench& bench) {
  boost::system::error_code failed;
  const json::value value = json::parse(text, failed);
  std::optional<Error> error;
  if (failed || !value.is_object()) {
    return Error{core::ErrorCode::kInvalid,
                 "the stored diagnosis is no JSON object",
                 "diagnosis",
                 "internal"};
  }
  const json::object& object = value.get_object();
  core::Diagnosis out;
  out.verdict = ReadVerdict(bench, object, error);
  DocumentReader reader(object, "", error);
  ReadEstimates(reader.Object("estimates"), error, out);
  for (const auto& [model, percent] : reader.Object("fit_percent")) {
    out.fit_percent.push_back({std::string(model), NumberOrAbsent(percent)});
  }
  for (const json::value& one : reader.Array("episodes")) {
    core::FaultEpisode episode;
    episode.verdict = ReadVerdict(bench, EntryOf(one), error);
    DocumentReader entry(EntryOf(one), "episodes/", error);
    const bool drift = entry.Text("shape") == "drift";
    episode.shape = drift ? core::FaultShape::kDrift : core::FaultShape::kAbrupt;
    episode.ended_at_s = entry.NumberOrNull("ended_at_s");
    out.episodes.push_back(std::move(episode));
  }
  if (error) return *error;
  if (const json::value* calibration = object.if_contains("calibration");
      calibration != nullptr && !calibration->is_null()) {
    TRY(out.calibration, CalibrationFromJson(*calibration, "stored diagnosis", bench));
  }
  return out;
}

}  // namespace faultlab::server
