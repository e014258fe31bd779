#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/result.h"
#include "faultlab_msgs/rig_command_t.hpp"
#include "hardware/rig.h"

namespace faultlab::hardware {

/// A plan on its way to an agent: "plan" brings a piece of its voltages, in any order and any of
/// them again; "arm" says how many there are, and the rest.
class ReceivedPlan {
 public:
  core::Status Take(const faultlab_msgs::rig_command_t& piece);
  /// @param missing  gets the first samples of the pieces that did not arrive, 64 at most; the
  ///                 plan is refused then
  core::Result<RunPlan> Assemble(const faultlab_msgs::rig_command_t& arm,
                                 const core::Bench& bench,
                                 std::vector<std::int64_t>& missing) const;
  void Clear() { pieces_.clear(); }

 private:
  std::map<std::int64_t, std::vector<double>> pieces_;  ///< by their first sample
};

}  // namespace faultlab::hardware
