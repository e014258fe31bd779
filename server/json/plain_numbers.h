#pragma once

#include <string>
#include <string_view>

namespace faultlab::server {

/// A JSON document with its numbers as people write them, 0.01 for 1E-2; the values are the same to
/// the last bit. What is no document stays as it is.
std::string WithPlainNumbers(std::string_view document);

}  // namespace faultlab::server
