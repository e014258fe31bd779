#pragma once

#include "server/api/api.h"

namespace faultlab::server {

/// Adds the routes of all handler files to the router.
void AddRoutes(Gate& gate, Router& router);

}  // namespace faultlab::server
