#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "server/lab/lab_types.h"
#include "server/run/rig_pool.h"

namespace faultlab::server {

/// By class, what its rigs are built like, and whether they are simulators of this server.
struct ClassOfRigs {
  const core::Bench* bench = nullptr;
  bool elastic = false;
};
using ClassBenches = std::map<std::string, ClassOfRigs>;

/// What rigs of each class are built like: this server's own, else a far one that it has in use
/// already, whose sessions a newcomer must not end, else the far one of the smallest id.
ClassBenches BenchesOfClasses(const std::vector<RigStatus>& rigs,
                              const lab::LabState& state,
                              std::string_view member);

/// Why nobody can use this rig now, although it is a rig of this server; empty: it can be used.
std::string WhyOffline(const RigStatus& rig, const ClassBenches& benches);

}  // namespace faultlab::server
