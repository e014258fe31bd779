#pragma once

#include <cstdint>

namespace faultlab::core {

/// Whether the model is all that the motor does: as BenchNorm::missing_physics says; of a
/// simulator it is; of a rig that somebody has built it is not, whatever the description says.
enum class ModelScope : std::uint8_t { kAsDescribed, kSimulator, kBuiltRig };

}  // namespace faultlab::core
