#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <string_view>
#include <variant>

#include "core/types/result.h"
#include "server/experiment/diagnosis_request.h"
#include "server/experiment/experiment_plan.h"

namespace faultlab::server {

/// What a job does: a run, or the diagnosis of a recording.
using Work = std::variant<ExperimentPlan, DiagnosisRequest>;

/// As a script writes it: the body of POST runs, or {"diagnose":{..}}. Errors name the field.
core::Result<Work> ParseWork(const boost::json::object& object, std::uint64_t default_seed);
/// As the job keeps it.
core::Result<Work> ParseWork(std::string_view document, std::uint64_t default_seed);

}  // namespace faultlab::server
