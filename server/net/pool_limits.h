#pragma once

#include <cstddef>

namespace faultlab::server {

struct PoolLimits {
  int threads = 4;
  std::size_t waiting_max = 1024;            ///< for a thread
  std::size_t waiting_per_caller_max = 512;  ///< of one caller
  int nice = 0;                              ///< above 0: gives way to other threads
};

}  // namespace faultlab::server
