#pragma once

#include <string>

#include "core/types/result.h"
#include "server/plots/figure.h"

namespace faultlab::server {

/// PNG at `scale`, or the figure as data when the name ends in ".json".
core::Status WriteFigure(const Figure& figure, const std::string& path, int scale);

}  // namespace faultlab::server
