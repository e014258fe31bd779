#pragma once

#include <cstdint>
#include <string>

#include "core/types/result.h"

namespace faultlab::server {

/// Space that must stay free on a disk, so that sign-ins, sessions and deletions remain possible.
struct DiskReserve {
  std::string folder{};    ///< a folder on that disk; empty: no check
  std::int64_t bytes = 0;  ///< 0: nothing is kept free

  /// kUnavailable "disk_full" when less is free.
  core::Status Check() const;
};

}  // namespace faultlab::server
