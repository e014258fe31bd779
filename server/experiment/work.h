#pragma once

#include <variant>

#include "server/experiment/diagnosis_request.h"
#include "server/experiment/experiment_plan.h"
#include "server/experiment/methods_request.h"

namespace faultlab::server {

/// What a job does: a run, the diagnosis of a recording, or methods compared on one. As a script
/// writes it: the body of POST runs, {"diagnose":{..}} or {"methods":{..}};
/// Experiments::ReadWork reads it.
using Work = std::variant<ExperimentPlan, DiagnosisRequest, MethodsRequest>;

}  // namespace faultlab::server
