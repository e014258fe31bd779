#pragma once

#include <string>

#include "core/types/result.h"
#include "server/storage/database.h"

namespace faultlab::server::lab {

/// A name that all servers of this database share and no other lab has: made once, at random, and
/// kept in the database. A restored copy of it is the same lab.
core::Result<std::string> LabId(Database& database);

/// What the servers of this database seal their requests to each other with (net/hop.h): made once,
/// at random. Who reads the database can claim any client's address, and nothing more by it.
core::Result<std::string> HopSecret(Database& database);

/// What the servers of this database seal sign-ins with that are on their way to a provider
/// (oidc/login_state.h): one server can finish what another one began.
core::Result<std::string> LoginSecret(Database& database);

}  // namespace faultlab::server::lab
