#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/fault.h"
#include "core/types/result.h"
#include "hardware/rig.h"
#include "server/experiment/experiment_plan.h"

namespace faultlab::server {

/// A plan as a person or a script writes it for this bench. Refuses unknown fields, wrong kinds and
/// values that no rig could take; Error.field is a JSON pointer.
core::Result<ExperimentPlan> ParsePlan(const boost::json::object& object,
                                       const core::Bench& bench,
                                       std::optional<std::uint64_t> default_seed);

/// The plan as it was resolved for `rig`, as the API shows and stores it: every field with its
/// value.
boost::json::object PlanToJson(const ExperimentPlan& plan, const hardware::RigDescription& rig);

/// A list of faults for a run of this length. Refuses by JSON pointer: "/faults/2/at_s".
core::Result<std::vector<core::Fault>> ParseFaults(const boost::json::array& list,
                                                   const core::Bench& bench,
                                                   double duration_s);
/// The same of a stored document, such as a fault set.
core::Result<std::vector<core::Fault>> ParseFaults(std::string_view document,
                                                   const core::Bench& bench,
                                                   double duration_s);
boost::json::array ToJson(const std::vector<core::Fault>& faults);

/// How long a stored plan lasts; 0 for a replay.
double SecondsOfPlan(std::string_view plan_json);
/// Of a simulator's noise; nothing where a stored plan tells none.
std::optional<std::uint64_t> SeedOfPlan(std::string_view plan_json);
/// Of a stored plan: its faults go to no bus.
bool HidesFaults(std::string_view plan_json);
/// A stored plan without what tells its faults: their list, and the seed of the noise, with which
/// the same run could be played healthy and compared.
std::string SealedPlan(std::string_view plan_json);
/// The trial whose run this is the plan of; 0: none.
std::int64_t TrialOf(std::string_view plan_json);
/// The same, stored as that of the run of a trial.
std::string SealedPlan(std::string_view plan_json, std::int64_t trial);
/// Stored with an upload that is, or contains, a copy of sealed records of these trials, with the
/// options of its diagnosis until it is opened.
std::string PlanOfCopy(const std::vector<std::int64_t>& trials, const std::string& options_json);
/// Those trials; of any other record none.
std::vector<std::int64_t> CopiedTrials(std::string_view plan_json);
/// Those options.
std::string OptionsOfCopy(std::string_view plan_json);
/// Such a stored plan with its faults and its seed again.
/// @param truth  {"faults": [..], "seed": N}
std::string OpenedPlan(std::string_view plan_json, std::string_view truth);
bool IsSealed(std::string_view plan_json);
/// The faults of a stored plan; empty when it has none.
std::vector<core::Fault> FaultsOfPlan(std::string_view plan_json, const core::Bench& bench);
/// An excitation as plans hold it.
boost::json::object ToJson(const core::ExcitationSpec& spec);

}  // namespace faultlab::server
