#pragma once

#include <span>

#include "server/api/api.h"
#include "server/api/gate.h"

namespace faultlab::server {

/// The routes of a handler file.
using ApiTable = std::span<const ApiRoute> (*)();
/// Those of all of them.
std::span<const ApiTable> ApiTables();
/// Adds them to the router.
void AddRoutes(Gate& gate, Router& router);

}  // namespace faultlab::server
