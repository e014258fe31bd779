#pragma once

#include <string>

#include "core/types/result.h"

namespace faultlab::server {

/// Does this name a PostgreSQL database? Also libpq's other spelling, "postgres://".
bool IsPostgres(const std::string& location);

/// The connection parameters of a PostgreSQL location, as SOCI can take them:
///   "postgresql://user@host:port/name?key=value"   libpq's URI
///   "postgresql:host=/run/pg dbname=lab"           libpq's keywords
/// libpq itself parses both; the answer is its keyword form, each value quoted. (SOCI 4.0.3 looks
/// for key=value pairs of its own and appends '=' to a URI that has none.)
/// kInvalid when it cannot be parsed. libpq's own words are left out: they quote parts of the
/// location, and one of them may be the password.
core::Result<std::string> PostgresParameters(const std::string& location);

}  // namespace faultlab::server
