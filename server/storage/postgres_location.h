#pragma once

#include <string>

#include "core/types/result.h"

namespace faultlab::server {

/// Whether this is the address of a PostgreSQL database, also in libpq's other spelling
/// "postgres://".
bool IsPostgres(const std::string& location);

/// The connection parameters of a PostgreSQL location, in a form that SOCI accepts:
///   "postgresql://user@host:port/name?key=value"   libpq's URI
///   "postgresql:host=/run/pg dbname=lab"           libpq's keywords
/// libpq itself parses both; the result is its keyword form, with each value quoted. (SOCI 4.0.3
/// searches for key=value pairs itself and appends '=' to a URI that has none.) kInvalid when it
/// cannot be parsed. The message leaves out libpq's text, which quotes parts of the location, and
/// one of them may be the password.
core::Result<std::string> PostgresParameters(const std::string& location);

}  // namespace faultlab::server
