#pragma once

#include <string>

namespace faultlab::hardware {

/// Rig names go into file names and channels: 1..40 of a-z A-Z 0-9 _ -.
bool IsRigName(const std::string& name);

/// A text from elsewhere as lists and files may have it: "(not UTF-8)" when it is not, cut between
/// two characters when it is longer than `bytes_max`.
std::string ShownText(const std::string& text, std::size_t bytes_max = 500);

}  // namespace faultlab::hardware
