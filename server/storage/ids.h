#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// A random id that cannot be guessed: prefix + "-" + 20 characters of [0-9a-z] (about 103 bits).
std::string NewId(std::string_view prefix);

}  // namespace faultlab::server
