#include "server/experiment/plan_json.h"

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>

#include "core/types/component_bounds.h"
#include "server/experiment/benches.h"
#include "server/experiment/control_json.h"
#include "server/json/json_reader.h"
#include "server/json/kept_json.h"
#include "server/json/list_of.h"
#include "server/run/refusals.h"

namespace faultlab::server {
namespace {

namespace json = boost::json;

// Wider than any rig: the rig's own envelope is checked by ResolvePlan.
constexpr double kVoltMax = 1000.0;
constexpr double kHertzMax = 1000.0;
constexpr std::int64_t kSeedMax = 1LL << 53;

/// Of a stored plan; null where it has none, or is damaged.
json::value MemberOf(std::string_view plan_json, std::string_view name) {
  const json::value plan = ParsedOr(plan_json);
  const json::value* member = MemberIn(plan, name);
  return member != nullptr ? *member : json::value(nullptr);
}

/// The bench's usual excitation where it is of this kind: what a plan leaves out is taken from it.
template <typename Spec>
Spec UsualOr(const core::ExcitationSpec& usual) {
  const Spec* spec = std::get_if<Spec>(&usual);
  return spec != nullptr ? *spec : Spec{};
}

core::Result<core::ExcitationSpec> ParseExcitation(const json::object& object,
                                                   const core::ExcitationSpec& usual) {
  ObjectReader in(object, "/excitation");
  const std::string_view kind =
      in.WordOr("kind", "prbs", {"prbs", "step", "multisine", "chirp", "samples"});
  core::ExcitationSpec spec;
  if (kind == "prbs") {
    auto prbs = UsualOr<core::PrbsSpec>(usual);
    prbs.low_v = in.NumberOr("low_v", prbs.low_v, -kVoltMax, kVoltMax);
    prbs.high_v = in.NumberOr("high_v", prbs.high_v, -kVoltMax, kVoltMax);
    prbs.clock_s = in.NumberOr("clock_s", prbs.clock_s, 0.001, 10.0);
    prbs.seed = static_cast<std::uint64_t>(in.IntegerOr("seed", 1, 0, kSeedMax));
    prbs.order = static_cast<int>(
        in.IntegerOr("order", prbs.order, core::kPrbsOrderMin, core::kPrbsOrderMax));
    spec = prbs;
  } else if (kind == "step") {
    auto step = UsualOr<core::StepSpec>(usual);
    step.low_v = in.NumberOr("low_v", step.low_v, -kVoltMax, kVoltMax);
    step.high_v = in.NumberOr("high_v", step.high_v, -kVoltMax, kVoltMax);
    step.at_s = in.NumberOr("at_s", step.at_s, 0.0, kRunSecondsMax);
    spec = step;
  } else if (kind == "multisine") {
    auto multisine = UsualOr<core::MultisineSpec>(usual);
    multisine.offset_v = in.NumberOr("offset_v", multisine.offset_v, -kVoltMax, kVoltMax);
    multisine.amplitude_v = in.NumberOr("amplitude_v", multisine.amplitude_v, 0.0, kVoltMax);
    multisine.lines = static_cast<int>(in.IntegerOr("lines", multisine.lines, 1, 1000));
    multisine.seed = static_cast<std::uint64_t>(in.IntegerOr("seed", 1, 0, kSeedMax));
    spec = multisine;
  } else if (kind == "chirp") {
    auto chirp = UsualOr<core::ChirpSpec>(usual);
    chirp.offset_v = in.NumberOr("offset_v", chirp.offset_v, -kVoltMax, kVoltMax);
    chirp.amplitude_v = in.NumberOr("amplitude_v", chirp.amplitude_v, 0.0, kVoltMax);
    chirp.from_hz = in.NumberOr("from_hz", chirp.from_hz, 0.0, kHertzMax);
    chirp.to_hz = in.NumberOr("to_hz", chirp.to_hz, 0.0, kHertzMax);
    spec = chirp;
  } else {
    core::SamplesSpec samples;
    const json::array* list = in.ArrayOrNull("uc_v", kRunSamplesMax);
    if (list == nullptr) in.Refuse("uc_v", "voltages_wrong");
    for (std::size_t i = 0; list != nullptr && i < list->size(); ++i) {
      const json::value& value = (*list)[i];
      const double volts = value.is_number() ? value.to_number<double>() : std::nan("");
      if (!std::isfinite(volts)) {
        in.Refuse(core::Refuse("voltages_wrong", "/excitation/uc_v/" + std::to_string(i)));
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
                                     const core::Bench& bench,
                                     double duration_s) {
  const json::object* object = value.if_object();
  if (object == nullptr) return core::Refuse("faults_unreadable", pointer);
  ObjectReader in(*object, pointer);
  core::Fault fault;
  const std::string name = in.Text("component", core::kSymbolBytesMax);
  const auto component = bench.Find(name);
  if (!component) {
    in.Refuse(refusal::At(refusal::NoComponent(bench, name), pointer + "/component"));
  } else {
    fault.component = *component;
  }
  fault.value = in.Number("value", 0.0, core::kComponentValueMax);
  if (fault.value <= 0.0) in.Refuse("value", "fault_value_not_positive");
  fault.at_s = in.NumberOr("at_s", std::min(10.0, duration_s / 2.0), 0.0, kRunSecondsMax);
  if (fault.at_s >= duration_s) {
    in.Refuse("at_s", "fault_outside_run");
  }
  const std::string_view kind = in.WordOr("kind", "abrupt", {"abrupt", "drift", "intermittent"});
  if (kind == "abrupt") {
    if (in.Has("until_s")) in.Refuse("until_s", "abrupt_has_no_end");
  } else {
    fault.kind = kind == "drift" ? core::FaultKind::kDrift : core::FaultKind::kIntermittent;
    fault.until_s = in.Number("until_s", 0.0, kRunSecondsMax);
    if (!in.error() && (fault.until_s <= fault.at_s || fault.until_s > duration_s)) {
      in.Refuse("until_s", "fault_end_outside");
    }
  }
  if (auto error = in.Finish()) return *error;
  return fault;
}

}  // namespace

json::object ToJson(const core::ExcitationSpec& spec) {
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

core::Result<ExperimentPlan> ParsePlan(const json::object& object,
                                       const core::Bench& bench,
                                       std::optional<std::uint64_t> default_seed) {
  ObjectReader in(object, "");
  ExperimentPlan plan;
  plan.bench = &bench;
  plan.period_s = bench.period_s;
  (void)in.TextOr("bench", {}, kBenchNameBytesMax);  // the caller has read it to find `bench`
  plan.rig = in.TextOr("rig", {}, 64);
  plan.name = in.TextOr("name", {}, kNameBytesMax);
  plan.recording = in.TextOr("recording", {}, 64);
  plan.seed = default_seed;
  if (object.contains("seed")) {
    plan.seed = static_cast<std::uint64_t>(in.IntegerOr("seed", 1, 0, kSeedMax));
  }
  plan.learn_if_needed = in.WordOr("learn", "anew", {"anew", "if_needed"}) == "if_needed";
  const bool replay = !plan.recording.empty();
  for (const char* own :
       {"learn", "bench", "rig", "excitation", "control", "faults", "duration_s", "period_s"}) {
    if (replay && in.Has(own)) {
      in.Refuse(own, "replay_has_its_own", {{"member", own}});
    }
  }
  plan.period_s = in.NumberOr("period_s", plan.period_s, 0.001, 1.0);
  plan.duration_s = in.NumberOr("duration_s", plan.duration_s, kRunSecondsMin, kRunSecondsMax);
  if (const json::object* excitation = in.ObjectOrNull("excitation")) {
    auto spec = ParseExcitation(*excitation, bench.excitation);
    if (spec) {
      plan.excitation = std::move(spec).value();
    } else {
      in.Refuse(spec.error());
    }
  } else {
    plan.excitation = bench.excitation;
  }
  if (const auto* samples = std::get_if<core::SamplesSpec>(&plan.excitation)) {
    const double length_s = static_cast<double>(samples->uc_v.size()) * plan.period_s;
    if (in.Has("duration_s") && std::abs(length_s - plan.duration_s) > plan.period_s / 2.0) {
      in.Refuse("duration_s", "duration_of_voltages");
    }
    plan.duration_s = length_s;
    if (length_s < kRunSecondsMin || length_s > kRunSecondsMax) {
      in.Refuse(core::Refuse("voltages_length", "/excitation/uc_v").As(core::ErrorCode::kInvalid));
    }
  }
  if (const json::object* wanted = in.ObjectOrNull("control")) {
    auto control = ParseControl(*wanted, bench, plan.period_s);
    if (control) {
      plan.control = std::move(control).value();
    } else {
      in.Refuse(control.error());
    }
  }
  if (in.Has("fault_set")) {
    plan.fault_set = in.Integer("fault_set", 1, INT64_MAX);
    if (in.Has("faults")) in.Refuse("fault_set", "faults_or_set");
    if (replay) in.Refuse("fault_set", "replay_has_its_own", {{"member", "fault_set"}});
  }
  plan.hidden_faults = in.BooleanOr("hidden_faults", false);
  if (const json::array* list = in.ArrayOrNull("faults", kRunFaultsMax)) {
    auto faults = ParseFaults(*list, bench, plan.duration_s);
    if (faults) {
      plan.faults = std::move(faults).value();
    } else {
      in.Refuse(faults.error());
    }
  }
  if (auto error = in.Finish()) return *error;
  return plan;
}

json::array ToJson(const std::vector<core::Fault>& faults) {
  return ListOf(faults, [](const core::Fault& fault) {
    json::object entry{{"component", core::Name(fault.component)},
                       {"value", fault.value},
                       {"at_s", fault.at_s},
                       {"kind", core::Name(fault.kind)}};
    if (fault.kind != core::FaultKind::kAbrupt) entry["until_s"] = fault.until_s;
    return entry;
  });
}

core::Result<std::vector<core::Fault>> ParseFaults(const json::array& list,
                                                   const core::Bench& bench,
                                                   double duration_s) {
  std::vector<core::Fault> faults;
  for (std::size_t i = 0; i < list.size(); ++i) {
    TRY(auto fault, ParseFault(list[i], "/faults/" + std::to_string(i), bench, duration_s));
    faults.push_back(fault);
  }
  return faults;
}

core::Result<std::vector<core::Fault>> ParseFaults(std::string_view document,
                                                   const core::Bench& bench,
                                                   double duration_s) {
  const json::value list = ParsedOr(document);
  if (list.is_array()) return ParseFaults(list.get_array(), bench, duration_s);
  return core::Error{
      core::ErrorCode::kInvalid, "The stored faults are damaged.", "/faults", "faults_unreadable"};
}

json::object PlanToJson(const ExperimentPlan& plan, const hardware::RigDescription& rig) {
  json::object out{{"rig", rig.id}, {"period_s", plan.period_s}};
  if (plan.hidden_faults) out["hidden_faults"] = true;
  if (!plan.recording.empty()) {
    out["recording"] = plan.recording;
    return out;
  }
  out["duration_s"] = plan.duration_s;
  out["excitation"] = ToJson(plan.excitation);
  if (plan.control) out["control"] = ToJson(*plan.control);
  if (plan.seed) out["seed"] = *plan.seed;
  out["faults"] = ToJson(plan.faults);
  return out;
}

double SecondsOfPlan(std::string_view plan_json) {
  const json::value seconds = MemberOf(plan_json, "duration_s");
  return seconds.is_number() ? seconds.to_number<double>() : 0.0;
}

std::optional<std::uint64_t> SeedOfPlan(std::string_view plan_json) {
  const json::value seed = MemberOf(plan_json, "seed");
  if (!seed.is_number()) return std::nullopt;
  return seed.to_number<std::uint64_t>();
}

bool HidesFaults(std::string_view plan_json) {
  const json::value hidden = MemberOf(plan_json, "hidden_faults");
  return hidden.is_bool() && hidden.get_bool();
}

std::int64_t TrialOf(std::string_view plan_json) {
  const json::value trial = MemberOf(plan_json, "trial");
  return trial.is_number() ? trial.to_number<std::int64_t>() : 0;
}

std::string SealedPlan(std::string_view plan_json) {
  json::object plan = json::parse(plan_json).as_object();
  plan.erase("faults");
  plan.erase("seed");
  plan["sealed"] = true;
  return json::serialize(plan);
}

std::string SealedPlan(std::string_view plan_json, std::int64_t trial) {
  json::object plan = json::parse(SealedPlan(plan_json)).as_object();
  plan["hidden_faults"] = true;
  plan["trial"] = trial;
  return json::serialize(plan);
}

std::string PlanOfCopy(const std::vector<std::int64_t>& trials, const std::string& options_json) {
  return json::serialize(json::object{{"sealed", true},
                                      {"copy_of", json::array(trials.begin(), trials.end())},
                                      {"options_when_open", options_json}});
}

std::vector<std::int64_t> CopiedTrials(std::string_view plan_json) {
  const json::value trials = MemberOf(plan_json, "copy_of");
  if (!trials.is_array()) return {};
  std::vector<std::int64_t> ids;
  for (const json::value& id : trials.get_array()) ids.push_back(id.to_number<std::int64_t>());
  return ids;
}

std::string OptionsOfCopy(std::string_view plan_json) {
  const json::value options = MemberOf(plan_json, "options_when_open");
  return options.is_string() ? std::string(options.get_string()) : std::string();
}

std::string OpenedPlan(std::string_view plan_json, std::string_view truth) {
  json::object plan = json::parse(plan_json).as_object();
  plan.erase("sealed");
  plan.erase("hidden_faults");
  const json::value opened = json::parse(truth);
  for (const auto& [name, value] : opened.as_object()) plan[name] = value;
  return json::serialize(plan);
}

bool IsSealed(std::string_view plan_json) {
  return !MemberOf(plan_json, "sealed").is_null();
}

std::vector<core::Fault> FaultsOfPlan(std::string_view plan_json, const core::Bench& bench) {
  const json::value list = MemberOf(plan_json, "faults");
  if (!list.is_array()) return {};
  auto faults = ParseFaults(list.get_array(), bench, kRunSecondsMax);
  return faults ? std::move(faults).value() : std::vector<core::Fault>{};
}

}  // namespace faultlab::server
