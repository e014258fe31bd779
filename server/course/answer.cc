#include "server/course/answer.h"

#include <boost/json.hpp>

#include "core/types/component_bounds.h"
#include "server/experiment/experiment_plan.h"
#include "server/json/json_reader.h"
#include "server/json/list_of.h"
#include "server/run/refusals.h"

namespace faultlab::server::course {
namespace {

namespace json = boost::json;

constexpr std::size_t kTextBytesMax = 4000;
constexpr std::size_t kUnitBytesMax = 20;

void ReadValue(ObjectReader& in, Answer& answer) {
  const std::string unit(core::Unit(*answer.component));
  answer.value = in.Number("value", 0.0, core::kComponentValueMax);
  if (answer.value <= 0.0) {
    in.Refuse("value", "fault_value_not_positive");
  }
  if (in.Text("unit", kUnitBytesMax) != unit) {
    in.Refuse("unit", "unit_wrong", {{"component", core::Name(*answer.component)}, {"unit", unit}});
  }
  if (in.Has("value_error")) {
    answer.value_error = in.Number("value_error", 0.0, core::kComponentValueMax);
  }
  if (in.Has("at_s")) answer.at_s = in.Number("at_s", 0.0, kRunSecondsMax);
}

std::vector<Evidence> ReadEvidence(ObjectReader& in) {
  std::vector<Evidence> evidence;
  const json::array* all = in.ArrayOrNull("evidence", kEvidenceMax);
  if (all == nullptr) return evidence;
  for (const json::value& each : *all) {
    const std::string pointer = in.Pointer("evidence") + "/" + std::to_string(evidence.size());
    const json::object* object = each.if_object();
    if (object == nullptr) {
      in.Refuse(core::Refuse("kind_wrong", pointer, {{"member", "evidence"}}));
      return evidence;
    }
    ObjectReader span(*object, pointer);
    const double from_s = span.Number("from_s", 0.0, kRunSecondsMax);
    const double to_s = span.Number("to_s", 0.0, kRunSecondsMax);
    if (to_s < from_s) {
      span.Refuse("to_s", "pool_range_backwards");
    }
    if (auto error = span.Finish()) in.Refuse(*std::move(error));
    evidence.push_back({from_s, to_s});
  }
  return evidence;
}

}  // namespace

core::Result<Answer> ParseAnswer(const json::object& body, const core::Bench& bench) {
  // null says "healthy"; a member that is forgotten says nothing.
  const json::value* named = body.if_contains("component");
  if (named == nullptr) {
    return core::Error{core::ErrorCode::kInvalid,
                       "Name a component, or null: the rig was healthy.",
                       "/component",
                       "member_missing",
                       {{"member", "component"}}};
  }
  json::object rest = body;
  if (named->is_null()) rest.erase("component");
  ObjectReader in(rest, "");
  Answer answer;
  if (!named->is_null()) {
    const std::string name = in.Text("component", core::kSymbolBytesMax);
    answer.component = bench.Find(name);
    if (!answer.component) {
      in.Refuse(refusal::At(refusal::NoComponent(bench, name), "/component"));
    } else {
      ReadValue(in, answer);
    }
  }
  answer.confidence = in.Number("confidence", 0.0, 1.0);
  answer.text = in.ProseOr("text", "", kTextBytesMax);
  answer.evidence = ReadEvidence(in);
  if (auto error = in.Finish()) return *error;
  return answer;
}

core::Result<Answer> ParseAnswer(std::string_view document, const core::Bench& bench) {
  TRY(auto body, ParseJsonObject(document));
  return ParseAnswer(body, bench);
}

json::object ToJson(const Answer& answer) {
  json::object out{
      {"component", nullptr}, {"confidence", answer.confidence}, {"text", answer.text}};
  if (!answer.evidence.empty()) {
    out["evidence"] = ListOf(answer.evidence, [](const Evidence& each) {
      return json::object{{"from_s", each.from_s}, {"to_s", each.to_s}};
    });
  }
  if (!answer.component) return out;
  out["component"] = core::Name(*answer.component);
  out["value"] = answer.value;
  out["unit"] = core::Unit(*answer.component);
  if (answer.value_error) out["value_error"] = *answer.value_error;
  if (answer.at_s) out["at_s"] = *answer.at_s;
  return out;
}

}  // namespace faultlab::server::course
