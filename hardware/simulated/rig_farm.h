#pragma once

#include <cstddef>
#include <memory>

#include "hardware/run_loop.h"

namespace faultlab::hardware {

/// A LoopRunner that steps many simulated rigs on one thread: a tick of a simulator is a
/// microsecond's work, its wake-up costs several. Loops are stepped in slots of 10 ms of real time,
/// each up to the end of the slot on its own clock; a slot that comes late is made up for.
///
/// Every task's clock must be one that never sleeps (simulated, speed 0): the farm does the pacing.
/// Commands act at the next tick as everywhere.
class RigFarm : public LoopRunner {
 public:
  /// Slots that began later than they should have, and by how much at worst.
  struct Load {
    std::size_t tasks = 0;
    std::uint64_t slots = 0;
    std::uint64_t late_slots = 0;  ///< by a whole slot or more
    double busy_share = 0.0;       ///< of the thread's time, since the start
  };
  virtual Load load() const = 0;
};

/// `max_tasks` bounds what one thread takes; Launch throws core::ContractError beyond it.
std::shared_ptr<RigFarm> MakeRigFarm(std::size_t max_tasks);

}  // namespace faultlab::hardware
