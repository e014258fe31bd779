#pragma once

#include <string>

#include "core/isolability/isolability.h"
#include "server/plots/figure.h"

namespace faultlab::server {

/// A fault set as a matrix: a row for each fault, a column for "healthy" and for each component
/// that it may be taken for. A cell holds the distance in nats; the fuller its colour, the easier
/// the mistake: full where the two cannot be told apart.
Figure MakeIsolabilityFigure(const core::Isolability& isolability, const std::string& subtitle);

}  // namespace faultlab::server
