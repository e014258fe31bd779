#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// openapi.json with the `security` of each operation, as the tables of routes and the matrix of
/// rights have it (by a key with its scope, in a session of the page, or by anybody), and with a
/// `description` that says who may.
std::string WithSecurity(std::string_view description);

}  // namespace faultlab::server
