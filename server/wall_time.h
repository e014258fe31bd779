#pragma once

#include <chrono>
#include <cstdint>

namespace faultlab::server {

/// Wall time, UTC, to the millisecond. Never mixed with run time, which is a double in seconds.
using WallTime = std::chrono::sys_time<std::chrono::milliseconds>;

inline std::int64_t ToMilliseconds(WallTime time) {
  return time.time_since_epoch().count();
}
inline WallTime FromMilliseconds(std::int64_t milliseconds) {
  return WallTime{std::chrono::milliseconds{milliseconds}};
}

}  // namespace faultlab::server
