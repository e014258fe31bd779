// Bodies of runs and jobs, and the faults of a set: a plan that passes is one that a rig can play
// or refuses, and what is stored of it is read back.
#include <boost/json.hpp>

#include "server/experiment/plan_json.h"
#include "server/experiment/work.h"
#include "server/json/json_reader.h"
#include "tests/fuzz/fuzz_input.h"

using namespace faultlab;  // NOLINT(google-build-using-namespace)
using fuzz::Require;

namespace {

/// Seconds of a plan may be many samples: an input is to cost little.
bool IsShort(const server::ExperimentPlan& plan) {
  return plan.duration_s / plan.period_s < 500.0;
}

void CheckPlan(const server::ExperimentPlan& plan) {
  hardware::RigDescription rig;
  rig.id = "fuzz";
  rig.any_value = rig.motor_faults = true;
  for (const core::Fault& fault : plan.faults) {
    Require(fault.value > 0.0 && fault.at_s >= 0.0 && fault.at_s < plan.duration_s);
  }
  const std::string stored = boost::json::serialize(server::PlanToJson(plan, rig));
  Require(server::FaultsOfPlan(stored).size() == plan.faults.size());
  Require(server::HidesFaults(stored) == plan.hidden_faults);
  if (!plan.recording.empty() || !IsShort(plan)) return;
  const auto resolved = server::ResolvePlan(plan, rig);
  if (!resolved) return Require(!resolved.error().message.empty());
  Require(!resolved.value().uc_v.empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = fuzz::Text(data, size);
  (void)server::ParseFaults(text, 20.0);
  (void)server::SecondsOfPlan(text);
  (void)server::FaultsOfPlan(text);
  const auto object = server::ParseJsonObject(text);
  if (!object) return 0;
  const auto work = server::ParseWork(object.value(), 1);
  if (!work) {
    Require(!work.error().message.empty());
    return 0;
  }
  if (const auto* plan = std::get_if<server::ExperimentPlan>(&work.value())) CheckPlan(*plan);
  return 0;
}
