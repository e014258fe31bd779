#pragma once

#include <string>
#include <string_view>

namespace faultlab::hardware {

/// Who holds a rig: "LAB/MEMBER". Servers of one database are members of one lab and make their
/// epochs together; what another lab holds is waited for.
inline std::string HolderName(std::string_view lab, std::string_view member) {
  return std::string(lab) + "/" + std::string(member);
}
inline std::string_view LabOf(std::string_view holder) {
  return holder.substr(0, holder.find('/'));
}

}  // namespace faultlab::hardware
