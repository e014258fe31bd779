#include "server/api/run_body.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>

#include "server/api/json_reader.h"
#include "server/run/switchable.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

// Wider than any rig: the rig's own envelope is checked by ResolvePlan.
constexpr double kVoltMax = 1000.0;
constexpr double kHertzMax = 1000.0;
constexpr double kComponentValueMax = 1e12;
constexpr std::int64_t kSeedMax = 1LL << 53;

core::Error Refusal(std::string field, std::string message) {
  return {core::ErrorCode::kInvalid, std::move(message), std::move(field)};
}

core::Result<core::ExcitationSpec> ParseExcitation(const json::object& object) {
  ObjectReader in(object, "/excitation");
  const std::string_view kind =
      in.WordOr("kind", "prbs", {"prbs", "step", "multisine", "chirp", "samples"});
  core::ExcitationSpec spec;
  if (kind == "prbs") {
    core::PrbsSpec prbs;
    prbs.low_v = in.NumberOr("low_v", prbs.low_v, -kVoltMax, kVoltMax);
    prbs.high_v = in.NumberOr("high_v", prbs.high_v, -kVoltMax, kVoltMax);
    prbs.clock_s = in.NumberOr("clock_s", prbs.clock_s, 0.001, 10.0);
    prbs.seed = static_cast<std::uint64_t>(in.IntegerOr("seed", 1, 0, kSeedMax));
    prbs.order = static_cast<int>(
        in.IntegerOr("order", prbs.order, core::kPrbsOrderMin, core::kPrbsOrderMax));
    spec = prbs;
  } else if (kind == "step") {
    core::StepSpec step;
    step.low_v = in.NumberOr("low_v", step.low_v, -kVoltMax, kVoltMax);
    step.high_v = in.NumberOr("high_v", step.high_v, -kVoltMax, kVoltMax);
    step.at_s = in.NumberOr("at_s", step.at_s, 0.0, kRunSecondsMax);
    spec = step;
  } else if (kind == "multisine") {
    core::MultisineSpec multisine;
    multisine.offset_v = in.NumberOr("offset_v", multisine.offset_v, -kVoltMax, kVoltMax);
    multisine.amplitude_v = in.NumberOr("amplitude_v", multisine.amplitude_v, 0.0, kVoltMax);
    multisine.lines = static_cast<int>(in.IntegerOr("lines", multisine.lines, 1, 1000));
    multisine.seed = static_cast<std::uint64_t>(in.IntegerOr("seed", 1, 0, kSeedMax));
    spec = multisine;
  } else if (kind == "chirp") {
    core::ChirpSpec chirp;
    chirp.offset_v = in.NumberOr("offset_v", chirp.offset_v, -kVoltMax, kVoltMax);
    chirp.amplitude_v = in.NumberOr("amplitude_v", chirp.amplitude_v, 0.0, kVoltMax);
    chirp.from_hz = in.NumberOr("from_hz", chirp.from_hz, 0.0, kHertzMax);
    chirp.to_hz = in.NumberOr("to_hz", chirp.to_hz, 0.0, kHertzMax);
    spec = chirp;
  } else {
    core::SamplesSpec samples;
    const json::array* list = in.ArrayOrNull("uc_v", kRunSamplesMax);
    if (list == nullptr) in.Refuse("uc_v", "'uc_v' must be the list of voltages, one per sample.");
    for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
      const json::value& value = (*list)[i];
      const double volts = value.is_number() ? value.to_number<double>() : std::nan("");
      if (!std::isfinite(volts)) {
        in.Refuse(Refusal("/excitation/uc_v/" + std::to_string(i), "A voltage must be a number."));
        break;
      }
      samples.uc_v.push_back(volts);
    }
    spec = samples;
  }
  if (auto error = in.Finish()) return *error;
  return spec;
}

core::Result<core::Fault> ParseFault(const json::value& value,
                                     const std::string& pointer,
                                     double duration_s) {
  const json::object* object = value.if_object();
  if (object == nullptr) return Refusal(pointer, "A fault must be an object.");
  ObjectReader in(*object, pointer);
  core::Fault fault;
  const std::string name = in.Text("component", 8);
  const auto component = core::ParseComponent(name);
  if (!component) {
    in.Refuse("component", "Unknown component '" + name + "'; known: R1, R9, R12, C8, Ra, J, B.");
  } else {
    fault.component = *component;
  }
  fault.value = in.Number("value", 0.0, kComponentValueMax);
  if (fault.value <= 0.0) in.Refuse("value", "'value' must be above 0, in the SI unit.");
  fault.at_s = in.NumberOr("at_s", std::min(10.0, duration_s / 2.0), 0.0, kRunSecondsMax);
  if (fault.at_s >= duration_s) {
    in.Refuse("at_s", "'at_s' must lie inside the run, before its end.");
  }
  const std::string_view kind = in.WordOr("kind", "abrupt", {"abrupt", "drift", "intermittent"});
  if (kind == "abrupt") {
    if (in.Has("until_s")) in.Refuse("until_s", "An abrupt fault has no 'until_s'.");
  } else {
    fault.kind = kind == "drift" ? core::FaultKind::kDrift : core::FaultKind::kIntermittent;
    fault.until_s = in.Number("until_s", 0.0, kRunSecondsMax);
    if (!in.error() && (fault.until_s <= fault.at_s || fault.until_s > duration_s)) {
      in.Refuse("until_s", "'until_s' must lie after 'at_s' and not behind the end of the run.");
    }
  }
  if (auto error = in.Finish()) return *error;
  return fault;
}

/// The member of the excitation to name when a voltage is outside the envelope.
std::string VoltageField(const core::ExcitationSpec& spec, std::size_t sample, bool above) {
  const std::string_view kind = core::Name(spec);
  if (kind == "samples") return "/excitation/uc_v/" + std::to_string(sample);
  if (kind == "multisine" || kind == "chirp") return "/excitation/amplitude_v";
  const auto ends = std::visit(
      [](const auto& s) -> std::pair<double, double> {
        if constexpr (requires { s.low_v; }) return {s.low_v, s.high_v};
        return {0.0, 0.0};
      },
      spec);
  const bool high = above == (ends.second >= ends.first);
  return high ? "/excitation/high_v" : "/excitation/low_v";
}

json::object ExcitationToJson(const core::ExcitationSpec& spec) {
  json::object out{{"kind", core::Name(spec)}};
  if (const auto* prbs = std::get_if<core::PrbsSpec>(&spec)) {
    out["low_v"] = prbs->low_v;
    out["high_v"] = prbs->high_v;
    out["clock_s"] = prbs->clock_s;
    out["order"] = prbs->order;
    out["seed"] = prbs->seed;
  } else if (const auto* step = std::get_if<core::StepSpec>(&spec)) {
    out["low_v"] = step->low_v;
    out["high_v"] = step->high_v;
    out["at_s"] = step->at_s;
  } else if (const auto* multisine = std::get_if<core::MultisineSpec>(&spec)) {
    out["offset_v"] = multisine->offset_v;
    out["amplitude_v"] = multisine->amplitude_v;
    out["lines"] = multisine->lines;
    out["seed"] = multisine->seed;
  } else if (const auto* chirp = std::get_if<core::ChirpSpec>(&spec)) {
    out["offset_v"] = chirp->offset_v;
    out["amplitude_v"] = chirp->amplitude_v;
    out["from_hz"] = chirp->from_hz;
    out["to_hz"] = chirp->to_hz;
  } else if (const auto* samples = std::get_if<core::SamplesSpec>(&spec)) {
    out["samples"] = samples->uc_v.size();  // the recording holds the values
  }
  return out;
}

}  // namespace

core::Result<RunBody> ParseRunBody(std::string_view text, std::uint64_t default_seed) {
  auto object = ParseJsonObject(text);
  if (!object) return object.error();
  ObjectReader in(object.value(), "");
  RunBody body;
  body.rig = in.TextOr("rig", {}, 64);
  body.name = in.TextOr("name", {}, kNameBytesMax);
  body.recording = in.TextOr("recording", {}, 64);
  body.seed = static_cast<std::uint64_t>(
      in.IntegerOr("seed", static_cast<std::int64_t>(default_seed), 0, kSeedMax));
  const bool replay = !body.recording.empty();
  for (const char* own : {"excitation", "faults", "duration_s", "period_s"}) {
    if (replay && in.Has(own)) {
      in.Refuse(own, "A replay takes '" + std::string(own) + "' from its recording.");
    }
  }
  body.period_s = in.NumberOr("period_s", body.period_s, 0.001, 1.0);
  body.duration_s = in.NumberOr("duration_s", body.duration_s, kRunSecondsMin, kRunSecondsMax);
  if (const json::object* excitation = in.ObjectOrNull("excitation")) {
    auto spec = ParseExcitation(*excitation);
    if (spec) {
      body.excitation = std::move(spec).value();
    } else {
      in.Refuse(spec.error());
    }
  }
  if (const auto* samples = std::get_if<core::SamplesSpec>(&body.excitation)) {
    const double length_s = static_cast<double>(samples->uc_v.size()) * body.period_s;
    if (in.Has("duration_s") && std::abs(length_s - body.duration_s) > body.period_s / 2.0) {
      in.Refuse("duration_s", "'duration_s' must be the length of 'uc_v', or absent.");
    }
    body.duration_s = length_s;
    if (length_s < kRunSecondsMin || length_s > kRunSecondsMax) {
      in.Refuse(Refusal("/excitation/uc_v", "The list must last from 1 s to 600 s."));
    }
  }
  if (body.duration_s / body.period_s > static_cast<double>(kRunSamplesMax) + 0.5) {
    in.Refuse("duration_s",
              "A run has at most " + std::to_string(kRunSamplesMax) +
                  " samples; shorten it or lengthen 'period_s'.");
  }
  const json::array* faults = in.ArrayOrNull("faults", kRunFaultsMax);
  for (std::size_t i = 0; faults != nullptr && i < faults->size() && !in.error(); ++i) {
    auto fault = ParseFault((*faults)[i], "/faults/" + std::to_string(i), body.duration_s);
    if (fault) {
      body.faults.push_back(fault.value());
    } else {
      in.Refuse(fault.error());
    }
  }
  if (auto error = in.Finish()) return *error;
  return body;
}

core::Result<hardware::RunPlan> ResolvePlan(const RunBody& body,
                                            const hardware::RigDescription& rig) {
  auto uc_v = core::Generate(body.excitation, body.duration_s, body.period_s);
  if (!uc_v) {
    core::Error error = uc_v.error();
    const bool top = error.field == "duration_s" || error.field == "period_s";
    error.field = (top ? "/" : "/excitation/") + error.field;
    return error;
  }
  hardware::RunPlan plan;
  plan.uc_v = std::move(uc_v).value();
  for (std::size_t i = 0; i < plan.uc_v.size(); ++i) {
    const double volts = plan.uc_v[i];
    if (volts >= rig.uc_v_min && volts <= rig.uc_v_max) continue;
    const json::value lo(rig.uc_v_min);
    const json::value hi(rig.uc_v_max);
    return Refusal(VoltageField(body.excitation, i, volts > rig.uc_v_max),
                   "The control voltage of rig '" + rig.id + "' goes from " + json::serialize(lo) +
                       " V to " + json::serialize(hi) + " V.");
  }
  for (std::size_t i = 0; i < body.faults.size(); ++i) {
    const core::Fault& fault = body.faults[i];
    const core::Status ok = CheckSwitchable(rig, fault.component, fault.value);
    if (ok.ok()) continue;
    return Refusal("/faults/" + std::to_string(i) + "/" + ok.error().field, ok.error().message);
  }
  plan.faults = body.faults;
  plan.period_s = body.period_s;
  plan.seed = body.seed;
  return plan;
}

json::object PlanToJson(const RunBody& body, const hardware::RigDescription& rig) {
  json::object out{{"rig", rig.id}, {"period_s", body.period_s}};
  if (!body.recording.empty()) {
    out["recording"] = body.recording;
    return out;
  }
  out["duration_s"] = body.duration_s;
  out["excitation"] = ExcitationToJson(body.excitation);
  out["seed"] = body.seed;
  json::array faults;
  for (const core::Fault& fault : body.faults) {
    json::object entry{{"component", core::Name(fault.component)},
                       {"value", fault.value},
                       {"at_s", fault.at_s},
                       {"kind", core::Name(fault.kind)}};
    if (fault.kind != core::FaultKind::kAbrupt) entry["until_s"] = fault.until_s;
    faults.push_back(std::move(entry));
  }
  out["faults"] = std::move(faults);
  return out;
}

std::vector<core::Fault> FaultsOfPlan(std::string_view plan_json) {
  std::vector<core::Fault> out;
  boost::system::error_code ec;
  const json::value plan = json::parse(plan_json, ec);
  const json::object* object = ec ? nullptr : plan.if_object();
  const json::value* list = object != nullptr ? object->if_contains("faults") : nullptr;
  if (list == nullptr || !list->is_array()) return out;
  for (const json::value& entry : list->get_array()) {
    if (auto fault = ParseFault(entry, "", kRunSecondsMax)) out.push_back(fault.value());
  }
  return out;
}

}  // namespace faultlab::server
