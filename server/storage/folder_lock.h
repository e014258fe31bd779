#pragma once

#include <string>

#include "core/types/result.h"

namespace faultlab::server {

/// One server per data folder: an exclusive lock on a file, held while this lives. The kernel gives
/// it back when the process dies, however it dies.
class FolderLock {
 public:
  /// Makes the file when it is missing. kConflict when another process holds it (the message has
  /// its process id), kUnavailable when the file cannot be made.
  static core::Result<FolderLock> Take(const std::string& path);

  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  ~FolderLock();

 private:
  explicit FolderLock(int fd) : fd_(fd) {}
  int fd_ = -1;
};

}  // namespace faultlab::server
