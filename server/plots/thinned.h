#pragma once

#include <optional>

#include "server/plots/figure.h"

namespace faultlab::server {

/// For a browser, which draws on some thousand pixels: of each 4000th of a long series its first,
/// lowest, highest and last point, in order; within `whole` every point. Gaps stay. A series of up
/// to 20 000 points stays as it is.
Series Thinned(Series series, const std::optional<Inset>& whole);

}  // namespace faultlab::server
