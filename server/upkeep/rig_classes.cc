#include "server/upkeep/rig_classes.h"

#include <tuple>

#include "server/experiment/rig_access.h"

namespace faultlab::server {
namespace {

/// Rigs of a class are interchangeable.
/// @returns why this far rig cannot be one of its class; empty: it can
std::string WhyNotOfItsClass(const RigStatus& rig, const ClassBenches& benches) {
  const auto of_class = benches.find(rig.description.rig_class);
  if (!rig.remote || of_class == benches.end()) return "";
  const auto& [bench, elastic] = of_class->second;
  if (elastic) {
    return "its class " + rig.description.rig_class +
           " is that of this server's simulators, which need no session: give its description "
           "another class";
  }
  if (rig.description.bench == nullptr || bench->id == rig.description.bench->id) return "";
  return "its class " + rig.description.rig_class + " has rigs built otherwise (" + bench->id +
         "): give its description another rig_class, or update it";
}

}  // namespace

ClassBenches BenchesOfClasses(const std::vector<RigStatus>& rigs,
                              const lab::LabState& state,
                              std::string_view member) {
  const auto is_new = [&](const RigStatus& rig) {
    const auto known = state.rigs.find(rig.description.id);
    return known == state.rigs.end() || known->second.status == lab::RigStatus::kOffline ||
           known->second.server != member;
  };
  std::map<std::string, const RigStatus*> first;
  for (const RigStatus& rig : rigs) {
    if (rig.description.rig_class.empty() || rig.description.bench == nullptr) continue;
    const RigStatus*& best = first[rig.description.rig_class];
    const auto rank = [&](const RigStatus& each) {
      return std::tuple(
          each.remote.has_value(), is_new(each), std::string_view(each.description.id));
    };
    if (best == nullptr || rank(rig) < rank(*best)) best = &rig;
  }
  ClassBenches benches;
  for (const auto& [name, rig] : first) {
    benches[name] = {rig->description.bench, !rig->remote && !NeedsSession(*rig)};
  }
  return benches;
}

std::string WhyOffline(const RigStatus& rig, const ClassBenches& benches) {
  if (rig.remote && rig.remote->refusal) return rig.remote->refusal_text;
  if (rig.state == hardware::RigState::kOffline) return "the rig does not answer";
  return WhyNotOfItsClass(rig, benches);
}

}  // namespace faultlab::server
