#include "server/experiment/rig_changes.h"

#include <algorithm>
#include <cmath>

#include "server/run/run_messages.h"

namespace faultlab::server {
namespace {

bool Same(double a, double b) {
  constexpr double kRelative = 1e-6;  // of numbers that went through JSON
  return std::abs(a - b) <= kRelative * std::max(std::abs(a), std::abs(b));
}

bool IsNominal(core::Component component, double value) {
  return Same(value, component.info().nominal);
}

/// Follows the values of the components that have been named so far.
class Teller {
 public:
  void Set(core::Component component, double value, double t_s) {
    const auto known = std::ranges::find(positions_, component, &Position::component);
    const double before = known == positions_.end() ? component.info().nominal : known->value;
    if (known == positions_.end()) {
      positions_.push_back({component, value});
    } else {
      known->value = value;
    }
    const bool nominal = IsNominal(component, value);
    if (nominal && IsNominal(component, before)) return;
    RigChange change{t_s, component, value, before, nominal, {}};
    for (const Position& other : positions_) {
      if (other.component != component && !IsNominal(other.component, other.value)) {
        change.others.push_back(other.component);
      }
    }
    changes_.push_back(std::move(change));
  }

  void SetAllNominal(double t_s) {
    const std::vector<Position> now = positions_;
    for (const Position& each : now) Set(each.component, each.component.info().nominal, t_s);
  }

  std::vector<RigChange> Changes() && { return std::move(changes_); }

 private:
  struct Position {
    core::Component component;
    double value = 0.0;
  };
  std::vector<Position> positions_;
  std::vector<RigChange> changes_;
};

}  // namespace

std::vector<RigChange> ChangesOf(std::span<const RecordedEvent> events,
                                 const core::Bench& bench,
                                 double period_s) {
  std::vector<const RecordedEvent*> in_order;
  for (const RecordedEvent& event : events) in_order.push_back(&event);
  std::ranges::stable_sort(in_order, {}, &RecordedEvent::index);
  Teller teller;
  for (const RecordedEvent* recorded : in_order) {
    const auto event = ToRigEvent(*recorded, bench);
    if (!event) continue;
    const double t_s = static_cast<double>(event->index) * period_s;
    if (event->kind == hardware::RigEventKind::kTrip) teller.SetAllNominal(t_s);
    if (event->kind != hardware::RigEventKind::kRelayConfirmed) continue;
    if (event->component.exists()) teller.Set(event->component, event->value, t_s);
  }
  return std::move(teller).Changes();
}

std::vector<core::Fault> FaultsToShow(std::span<const RigChange> changes,
                                      std::vector<core::Fault> planned) {
  std::vector<core::Fault> drifts;
  std::ranges::copy_if(planned, std::back_inserter(drifts), [](const core::Fault& fault) {
    return fault.kind == core::FaultKind::kDrift;
  });
  std::vector<core::Fault> shown = drifts;
  for (const RigChange& change : changes) {
    const bool of_a_drift = std::ranges::any_of(drifts, [&](const core::Fault& drift) {
      return drift.component == change.component && change.t_s <= drift.until_s &&
             change.t_s >= drift.at_s;
    });
    if (of_a_drift) continue;
    shown.push_back({.component = change.component, .value = change.value, .at_s = change.t_s});
  }
  if (changes.empty()) return planned;
  std::ranges::stable_sort(shown, {}, &core::Fault::at_s);
  return shown;
}

}  // namespace faultlab::server
