#pragma once

#include <vector>

#include "server/api/gate.h"
#include "server/experiment/benches.h"

namespace faultlab::server {

/// What the benches are, and the models that their parts give: for everybody, the same for all.
/// @param benches  must outlive the routes
std::vector<ApiRoute> BenchRoutes(Benches& benches);

}  // namespace faultlab::server
