#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/signals/excitation.h"
#include "core/types/fault.h"
#include "core/types/result.h"
#include "hardware/rig.h"
#include "hardware/run_plan.h"

namespace faultlab::server {

class SealedWitness;

inline constexpr double kRunSecondsMin = 1.0;
inline constexpr double kRunSecondsMax = 600.0;
inline constexpr std::int64_t kRunSamplesMax = 600'000;  // 600 s at 1 kHz
inline constexpr std::size_t kRunFaultsMax = 64;
inline constexpr std::size_t kNameBytesMax = 200;

struct WantedControl {
  core::SpeedReference reference;
  core::ToleranceOptions options;
};

/// What somebody wants to run: the usual experiment of the bench, unless they say otherwise.
struct ExperimentPlan {
  const core::Bench* bench = nullptr;  ///< that the plan was written for; never null
  std::string rig;                     ///< empty: any free simulated rig of the bench
  core::ExcitationSpec excitation;
  double period_s = 0.01;
  double duration_s = 20.0;
  std::vector<core::Fault> faults;
  std::optional<WantedControl> control{};  ///< the speed is kept once the rig is learnt
  std::int64_t fault_set = 0;              ///< not 0: take the faults of this set
  /// Samples, estimates and events go to no bus. Always so for a set that students do not see.
  bool hidden_faults = false;
  /// Start with what a recent run learnt about the rig, if there is one, instead of learning it.
  bool learn_if_needed = false;
  std::optional<std::uint64_t> seed;  ///< of a simulator's noise; none: the server draws one
  /// The trial whose run this is; 0: none. With `witness`: see SealedWitness.
  std::int64_t trial = 0;
  std::shared_ptr<SealedWitness> witness{};
  std::string recording;  ///< not empty: replay this one; excitation and faults are its own
  std::string name;
};

/// What the rig plays. Refuses what is outside its envelope or what it cannot switch; Error.field
/// is a JSON pointer into the plan.
core::Result<hardware::RunPlan> ResolvePlan(const ExperimentPlan& plan,
                                            const hardware::RigDescription& rig);

}  // namespace faultlab::server
