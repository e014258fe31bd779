#include "tests/support/paths.h"

namespace faultlab::tests {

std::string InSource(const std::string& path) {
  return std::string(FAULTLAB_SOURCE_DIR "/") + path;
}

std::string InBuild(const std::string& path) {
  return std::string(FAULTLAB_BINARY_DIR "/") + path;
}

std::string Program() {
  return InBuild("faultlab");
}

}  // namespace faultlab::tests
