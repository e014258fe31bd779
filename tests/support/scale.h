#pragma once

#include <cstdlib>
#include <string_view>

namespace faultlab::tests {

/// True in `deploy/prove`, which has hours; the check takes a sample of the same.
inline bool Proving() {
  const char* const text = std::getenv("FAULTLAB_PROVE");
  return text != nullptr && std::string_view(text) == "1";
}

}  // namespace faultlab::tests
