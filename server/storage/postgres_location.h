#pragma once

#include <string>

#include "core/types/result.h"

namespace faultlab::server {

/// The connection parameters of a PostgreSQL location, as SOCI can take them:
///   "postgresql://user@host:port/name?key=value"   libpq's URI
///   "postgresql:host=/run/pg dbname=lab"           libpq's keywords
/// libpq itself parses both; the answer is its keyword form, each value quoted. (SOCI 4.0.3 looks
/// for key=value pairs of its own and appends '=' to a URI that has none.)
/// kInvalid with libpq's own words when it cannot be parsed.
core::Result<std::string> PostgresParameters(const std::string& location);

}  // namespace faultlab::server
