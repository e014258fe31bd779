#pragma once

#include <string>

namespace faultlab::hardware {

/// Rig names go into file names and channels: 1..40 of a-z A-Z 0-9 _ -.
bool IsRigName(const std::string& name);

}  // namespace faultlab::hardware
