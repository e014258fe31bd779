#pragma once

#include <string>

#include "core/types/result.h"
#include "server/storage/database.h"

namespace faultlab::server::lab {

/// A name that all servers of this database share and no other lab has: made once, at random, and
/// stored in the database. A restored copy of the database is the same lab.
core::Result<std::string> LabId(Database& database);

/// The key with which the servers of this database seal their requests to each other
/// (net/forwarding_seal.h): made once, at random. Somebody who reads the database can forge a
/// client's address with it, and nothing else.
core::Result<std::string> HopSecret(Database& database);

/// The key with which the servers of this database seal unfinished sign-ins at a provider
/// (oidc/login_state.h), so that one server can finish a sign-in that another one began.
core::Result<std::string> LoginSecret(Database& database);

}  // namespace faultlab::server::lab
