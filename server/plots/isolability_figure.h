#pragma once

#include <string>

#include "core/isolability/isolability.h"
#include "server/plots/figure.h"

namespace faultlab::server {

/// A fault set as a matrix: a row for each fault, a column for "healthy" and for each component
/// with which it may be confused. A cell contains the distance in nats; the darker it is, the
/// easier the two are confused: full colour means that they cannot be distinguished.
Figure MakeIsolabilityFigure(const core::Isolability& isolability, const std::string& subtitle);

}  // namespace faultlab::server
