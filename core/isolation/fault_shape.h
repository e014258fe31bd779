#pragma once

namespace faultlab::core {

/// How the winning parameter moves inside the fitted stretch.
enum class FaultShape { kAbrupt, kDrift };

}  // namespace faultlab::core
