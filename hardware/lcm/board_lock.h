#pragma once

#include <string>
#include <utility>

#include "core/types/result.h"
#include "hardware/config/bench_file.h"

namespace faultlab::hardware {

/// One program drives a board at a time: a self-test beside a running agent would move its relays.
/// Advisory (flock), on a Comedi board's own device node, for other boards on a file beside the
/// rig's epoch. The second process, which makes the bench safe, takes
/// none: who has the lock may hang.
class BoardLock {
 public:
  /// kConflict when another program has it. A node that cannot be opened is left to the driver,
  /// which says why.
  static core::Result<BoardLock> Take(const BenchFile& file, const std::string& state_directory);

  ~BoardLock();
  BoardLock(BoardLock&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  BoardLock& operator=(BoardLock&&) = delete;

 private:
  explicit BoardLock(int file) : file_(file) {}
  int file_;
};

}  // namespace faultlab::hardware
