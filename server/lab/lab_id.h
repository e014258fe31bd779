#pragma once

#include <string>

#include "core/types/result.h"
#include "server/storage/database.h"

namespace faultlab::server::lab {

/// A name that all servers of this database share and no other lab has: made once, at random, and
/// kept in the database. A restored copy of it is the same lab.
core::Result<std::string> LabId(Database& database);

}  // namespace faultlab::server::lab
