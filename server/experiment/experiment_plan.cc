#include "server/experiment/experiment_plan.h"

#include <utility>
#include <variant>

#include "core/control/closed_loop/orders.h"
#include "server/run/refusals.h"
#include "server/run/switchable.h"

namespace faultlab::server {
namespace {

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

}  // namespace

core::Result<hardware::RunPlan> ResolvePlan(const ExperimentPlan& wanted,
                                            const hardware::RigDescription& rig) {
  if (wanted.bench != rig.bench) {
    return core::Refuse(
        "other_bench",
        "/bench",
        {{"rig", rig.id}, {"bench", rig.bench->name}, {"asked", wanted.bench->name}});
  }
  auto uc_v = core::Generate(wanted.excitation, wanted.duration_s, wanted.period_s);
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
    return refusal::At(
        core::Refuse("voltage_outside",
                     "/excitation",
                     {{"rig", rig.id}, {"lowest_v", rig.uc_v_min}, {"highest_v", rig.uc_v_max}}),
        VoltageField(wanted.excitation, i, volts > rig.uc_v_max));
  }
  for (std::size_t i = 0; i < wanted.faults.size(); ++i) {
    const core::Fault& fault = wanted.faults[i];
    const core::Status ok = CheckSwitchable(rig, fault.component, fault.value);
    if (ok.ok()) continue;
    return refusal::At(ok.error(), "/faults/" + std::to_string(i) + "/" + ok.error().field);
  }
  if (wanted.control) {
    if (!rig.controls_speed) return core::Refuse("no_speed_control", "/control", {{"rig", rig.id}});
    const double reachable = core::DescribedDrive(*rig.bench, wanted.period_s).reachable_rad_s();
    if (wanted.control->reference.highest() > reachable)
      return core::Refuse("speed_out_of_reach",
                          "/control/reference/high_rad_s",
                          {{"reachable_rad_s", std::floor(reachable)}});
    plan.control = {.reference = wanted.control->reference, .options = wanted.control->options};
  }
  plan.faults = wanted.faults;
  plan.period_s = wanted.period_s;
  plan.seed = wanted.seed.value_or(1);
  return plan;
}

}  // namespace faultlab::server
