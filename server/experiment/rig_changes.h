#pragma once

#include <span>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/component.h"
#include "core/types/fault.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

/// A component has another value since `t_s`: the rig has confirmed it.
struct RigChange {
  double t_s = 0.0;
  core::Component component{};
  double value = 0.0;   ///< SI
  double before = 0.0;  ///< its value until then
  bool nominal = false;
  std::vector<core::Component> others;  ///< that were not nominal then
};

/// What the events of a run say that happened to its rig, in time order. An interlock sets all
/// components back to nominal; what was nominal and stays so is no change.
std::vector<RigChange> ChangesOf(std::span<const RecordedEvent> events,
                                 const core::Bench& bench,
                                 double period_s);

/// The same for figures: a drift, which no rig confirms value by value, is as it was planned. As
/// planned altogether when the rig has reported nothing.
std::vector<core::Fault> FaultsToShow(std::span<const RigChange> changes,
                                      std::vector<core::Fault> planned);

}  // namespace faultlab::server
