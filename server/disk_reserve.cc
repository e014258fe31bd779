#include "server/disk_reserve.h"

#include <filesystem>

namespace faultlab::server {

core::Status DiskReserve::Check() const {
  if (bytes == 0 || folder.empty()) return core::Done{};
  std::error_code ec;
  const auto space = std::filesystem::space(folder, ec);
  // If the free space is unknown, errors appear when the disk is written.
  if (ec || space.available > static_cast<std::uintmax_t>(bytes)) return core::Done{};
  return core::Refuse("disk_full");
}

}  // namespace faultlab::server
