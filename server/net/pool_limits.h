#pragma once

#include <cstddef>

namespace faultlab::server {

struct PoolLimits {
  int threads = 4;
  std::size_t waiting_max = 1024;            ///< tasks that wait for a thread
  std::size_t waiting_per_caller_max = 512;  ///< of one caller
  int nice = 0;                              ///< above 0: lower priority than other threads
  /// Threads that one lane may use; at most half of `waiting_max` wait in it. 0: no limit.
  int threads_per_lane = 0;
};

}  // namespace faultlab::server
