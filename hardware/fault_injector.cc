#include "hardware/fault_injector.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/types/plant_parameters.h"
#include "hardware/refusal.h"

namespace faultlab::hardware {
namespace {

/// Rounding of sample times.
constexpr double kTimeSlackS = 1e-9;

}  // namespace

FaultInjector::FaultInjector(const RigDescription& description,
                             double relay_rest_s,
                             RelayBoard& relays,
                             SimulatorPort* port)
    : description_(description), relay_rest_s_(relay_rest_s), relays_(relays), port_(port) {}

core::Status FaultInjector::CheckValue(core::Component component,
                                       double value,
                                       const std::string& field) const {
  const std::string name(core::Name(component));
  if (!(std::isfinite(value) && value > 0.0)) {
    return core::Refuse("value_not_positive", field, {{"component", name}});
  }
  if (!core::IsSwitched(component)) {
    if (description_.motor_faults && port_ != nullptr) return core::Done{};
    return core::Refuse(
        "component_not_switchable", field, {{"rig", description_.id}, {"component", name}});
  }
  if (RelayPositionOf(component, value) >= 0) return core::Done{};
  if (description_.any_value && port_ != nullptr) return core::Done{};
  std::string values;
  for (const core::SwitchPosition& known : component.info().positions) {
    values += (values.empty() ? "" : ", ") + Number(known.value);
  }
  return core::Refuse("value_not_of_the_relays",
                      field,
                      {{"component", name}, {"values", values}, {"unit", core::Unit(component)}});
}

core::Status FaultInjector::Check(const RigCommand& command) const {
  if (command.kind == RigCommand::Kind::kControl) return NoSpeedControl(description_.id);
  if (command.kind != RigCommand::Kind::kSetComponent) return core::Done{};
  return CheckValue(command.component, command.value, "value");
}

core::Status FaultInjector::Check(const RunPlan& plan) const {
  for (std::size_t i = 0; i < plan.faults.size(); ++i) {
    const core::Fault& fault = plan.faults[i];
    const std::string field = "faults/" + std::to_string(i);
    if (auto good = core::Validate(fault); !good) {
      return Invalid(good.error().message, field + "/" + good.error().field, good.error().reason);
    }
    if (auto good = CheckValue(fault.component, fault.value, field + "/value"); !good) return good;
    const bool by_relay = core::IsSwitched(fault.component);
    if (fault.kind == core::FaultKind::kDrift && by_relay &&
        (port_ == nullptr || !description_.any_value)) {
      return core::Refuse(
          "relays_jump", field + "/kind", {{"component", core::Name(fault.component)}});
    }
    if (!by_relay) continue;
    // Switching times of one board must leave its relays their rest.
    std::vector<double> times;
    for (const core::Fault& other : plan.faults) {
      if (other.component != fault.component) continue;
      times.push_back(other.at_s);
      if (other.kind == core::FaultKind::kIntermittent) times.push_back(other.until_s);
    }
    std::ranges::sort(times);
    for (std::size_t k = 1; k < times.size(); ++k) {
      const double apart_s = times[k] - times[k - 1];
      if (apart_s > kTimeSlackS && apart_s < relay_rest_s_ - kTimeSlackS) {
        return core::Refuse("relays_rest",
                            field + "/at_s",
                            {{"component", core::Name(fault.component)},
                             {"apart_s", Number(apart_s)},
                             {"rest_s", Number(relay_rest_s_)}});
      }
    }
  }
  return core::Done{};
}

void FaultInjector::Begin(const RunPlan& plan) {
  faults_ = plan.faults;
  schedule_.emplace(plan.faults, description_.bench->nominal);
  parts_ = {};
  for (const core::Fault& fault : faults_) part(fault.component).scheduled = true;
  for (const core::Component component : description_.bench->components()) {
    part(component).scheduled_value = NominalOf(component);
  }
}

void FaultInjector::Want(core::Component component, double value, bool live) {
  Part& p = part(component);
  p.wanted = value;
  p.live = live;
  p.overruled = live && p.drifting;
  p.drifting = false;
}

void FaultInjector::Accept(std::span<const RigCommand> commands,
                           std::int64_t index,
                           std::vector<RigMessage>& out) {
  for (const RigCommand& command : commands) {
    if (command.kind == RigCommand::Kind::kControl) continue;
    if (command.kind == RigCommand::Kind::kAllNominal) {
      for (const core::Component component : description_.bench->components()) {
        Want(component, NominalOf(component), true);
      }
      continue;
    }
    const Part& p = part(command.component);
    if (p.wanted && p.live) {
      out.emplace_back(RigEvent{.kind = RigEventKind::kRefused,
                                .index = index,
                                .component = command.component,
                                .value = *p.wanted,
                                .text = "a newer command came before this one could act"});
    }
    Want(command.component, command.value, true);
  }
}

const core::Fault* FaultInjector::DriftAt(core::Component component, double t_s) const {
  for (const core::Fault& fault : faults_) {
    if (fault.component == component && fault.kind == core::FaultKind::kDrift &&
        t_s >= fault.at_s - kTimeSlackS && t_s < fault.until_s) {
      return &fault;
    }
  }
  return nullptr;
}

/// What the schedule says at t_s: step changes are queued as requests, a drift moves the part by
/// itself.
void FaultInjector::Follow(core::Component component,
                           std::int64_t index,
                           double t_s,
                           std::vector<RigMessage>& out) {
  Part& p = part(component);
  const double value = schedule_->ValueAt(component, t_s);
  const double before = std::exchange(p.scheduled_value, value);
  const core::Fault* drift = DriftAt(component, t_s);
  if (p.overruled) {
    p.overruled = drift != nullptr;
    return;
  }
  if (drift != nullptr && !p.drifting) {
    p.drifting = p.off_table = true;
    p.wanted.reset();
    out.emplace_back(RigEvent{.kind = RigEventKind::kFaultCommanded,
                              .index = index,
                              .component = component,
                              .value = drift->value,
                              .text = "drift until " + Number(drift->until_s) + " s"});
  }
  if (p.drifting) {
    port_->Drift(component, value);
    if (drift == nullptr) p.unconfirmed = value;
    p.drifting = drift != nullptr;
  } else if (value != before) {
    Want(component, value, false);
  }
}

void FaultInjector::Act(std::int64_t index, double t_s, std::vector<RigMessage>& out) {
  for (const core::Component component : description_.bench->components()) {
    Part& p = part(component);
    if (p.scheduled) Follow(component, index, t_s, out);
    if (!p.wanted) continue;
    const double value = *p.wanted;
    const int position = core::IsSwitched(component) ? RelayPositionOf(component, value) : -1;
    const bool switches = position >= 0 && position != relays_.position(component);
    if (switches && t_s - p.switched_at_s < relay_rest_s_ - kTimeSlackS) continue;
    // All-nominal of a component that is nominal is no news.
    const bool same = position >= 0 && !switches && !p.off_table;
    const bool silent =
        p.live && ((same && position == 0) ||
                   (!core::IsSwitched(component) && !p.off_table && value == NominalOf(component)));
    p.wanted.reset();
    if (silent) continue;

    if (position >= 0) {
      if (p.off_table) port_->Clear(component);
      p.off_table = false;
      relays_.Request(component, position);
      if (switches) p.switched_at_s = t_s;
    } else {
      port_->Set(component, value);
      p.off_table = true;
    }
    out.emplace_back(RigEvent{.kind = RigEventKind::kFaultCommanded,
                              .index = index,
                              .component = component,
                              .value = value,
                              .text = p.live       ? std::string(kLiveText)
                                      : p.drifting ? "drift"
                                                   : "scheduled"});
    p.unconfirmed = value;
  }
}

void FaultInjector::Confirm(std::int64_t index, std::vector<RigMessage>& out) {
  for (const core::Component component : description_.bench->components()) {
    Part& p = part(component);
    if (!p.unconfirmed) continue;
    out.emplace_back(RigEvent{.kind = RigEventKind::kRelayConfirmed,
                              .index = index,
                              .component = component,
                              .value = *p.unconfirmed,
                              .text = ""});
    p.unconfirmed.reset();
  }
}

}  // namespace faultlab::hardware
