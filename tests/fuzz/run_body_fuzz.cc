// Bodies of runs and jobs, and the faults of a set: a rig can play or refuse an accepted plan, and
// the stored plan can be read back.
#include <boost/json.hpp>

#include "server/experiment/diagnosis_request.h"
#include "server/experiment/plan_json.h"
#include "server/json/json_reader.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/paper_bench.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

namespace {

/// A plan of some seconds may have many samples; this keeps the time of an input short.
bool IsShort(const server::ExperimentPlan& plan) {
  return plan.duration_s / plan.period_s < 500.0;
}

void CheckPlan(const server::ExperimentPlan& plan) {
  hardware::RigDescription rig;
  rig.bench = &faultlab::paper::Bench();
  rig.id = "fuzz";
  rig.uc_v_max = 5.0;
  rig.any_value = rig.motor_faults = true;
  for (const core::Fault& fault : plan.faults) {
    Require(fault.value > 0.0 && fault.at_s >= 0.0 && fault.at_s < plan.duration_s);
  }
  const std::string stored = boost::json::serialize(server::PlanToJson(plan, rig));
  Require(server::FaultsOfPlan(stored, *rig.bench).size() == plan.faults.size());
  Require(server::HidesFaults(stored) == plan.hidden_faults);
  if (!plan.recording.empty() || !IsShort(plan)) return;
  const auto resolved = server::ResolvePlan(plan, rig);
  if (!resolved) return Require(!resolved.error().message.empty());
  Require(!resolved.value().uc_v.empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::Text(data, size);
  (void)server::ParseFaults(text, paper::Bench(), 20.0);
  (void)server::SecondsOfPlan(text);
  (void)server::FaultsOfPlan(text, paper::Bench());
  const auto object = server::ParseJsonObject(text);
  if (!object) return 0;
  const auto request = server::ParseDiagnosisRequest(object.value());
  Require(request.ok() || !request.error().message.empty());
  const auto plan = server::ParsePlan(object.value(), paper::Bench(), 1);
  if (plan) {
    CheckPlan(plan.value());
  } else {
    Require(!plan.error().message.empty());
  }
  return 0;
}
