#pragma once

#include <cstddef>

namespace faultlab::server {

struct PoolLimits {
  int threads = 4;
  std::size_t waiting_max = 1024;            ///< for a thread
  std::size_t waiting_per_caller_max = 512;  ///< of one caller
  int nice = 0;                              ///< above 0: gives way to other threads
  /// Of a lane: how many threads work for it, and half of `waiting_max` wait. 0: as many as there
  /// are.
  int threads_per_lane = 0;
};

}  // namespace faultlab::server
