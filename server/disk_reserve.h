#pragma once

#include <cstdint>
#include <string>

#include "core/types/result.h"

namespace faultlab::server {

/// What must stay free on a disk, for sign-ins, sessions and deletions to go on.
struct DiskReserve {
  std::string folder{};    ///< on that disk; empty: nothing is watched
  std::int64_t bytes = 0;  ///< 0: nothing is kept free

  /// kUnavailable "disk_full" when less is free.
  core::Status Check() const;
};

}  // namespace faultlab::server
