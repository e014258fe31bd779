#pragma once

#include <vector>

#include "server/api/gate.h"

namespace faultlab::server {

/// What the bench of a rig is, and the model that its parts give: for everybody, the same for all.
std::vector<ApiRoute> BenchRoutes();

}  // namespace faultlab::server
