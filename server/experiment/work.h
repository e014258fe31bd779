#pragma once

#include <variant>

#include "server/experiment/diagnosis_request.h"
#include "server/experiment/experiment_plan.h"

namespace faultlab::server {

/// What a job does: a run, or the diagnosis of a recording. As a script writes it: the body of POST
/// runs, or {"diagnose":{..}}; Experiments::ReadWork reads it.
using Work = std::variant<ExperimentPlan, DiagnosisRequest>;

}  // namespace faultlab::server
