#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/bench/bench.h"
#include "core/bench/profile.h"
#include "core/control/speed_reference.h"
#include "core/control/tolerant_drive.h"
#include "core/types/calibration.h"
#include "core/types/fault.h"
#include "core/types/sample.h"

namespace faultlab::core {

/// A simulated run under speed control, as it was recorded.
struct ControlledRecord {
  const Bench* bench = nullptr;           ///< never null
  const BenchProfile* profile = nullptr;  ///< of the simulator; never null
  std::span<const double> uc_v;           ///< of every sample from the first on, none left out
  std::size_t began = 0;                  ///< sample at which the control began, > 0
  std::size_t reference_from = 0;         ///< sample of the reference's beginning, <= began
  SpeedReference reference;
  std::vector<Fault> faults;
  Calibration calibration;  ///< what was learnt before
  double period_s = 0.01;
  std::uint64_t seed = 1;
};

/// The same run with the controller of the healthy rig and no diagnosis: the same uc until the
/// control began, the same faults and noise.
std::vector<Sample> WithoutCompensation(const ControlledRecord& record);

}  // namespace faultlab::core
