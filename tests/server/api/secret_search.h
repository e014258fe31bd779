#pragma once

#include <string>
#include <vector>

namespace faultlab::server {

/// How numbers that appear nowhere by chance could be told: as text, and as the bytes of a double
/// in either order.
std::vector<std::string> TracesOf(const std::vector<double>& secrets);
/// A path of the API's description with the ids of a run and of what a fresh lab has.
std::string TargetOf(std::string path, const std::string& run);
/// Pictures, exports, reports.
bool IsFile(const std::string& path);

}  // namespace faultlab::server
