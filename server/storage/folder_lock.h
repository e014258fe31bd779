#pragma once

#include <string>

#include "core/types/result.h"

namespace faultlab::server {

/// One server per database file: an exclusive lock, held while this lives. The kernel gives it back
/// when the process dies, however it dies.
class FolderLock {
 public:
  /// Of a lock file at `path`, made when it is missing. Links to it are followed: whatever the
  /// names, one file is locked once. kConflict when another process holds it (the message has its
  /// process id), kUnavailable when the file cannot be made.
  static core::Result<FolderLock> Take(const std::string& path);

  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  ~FolderLock();

 private:
  explicit FolderLock(int fd) : fd_(fd) {}
  int fd_ = -1;
};

}  // namespace faultlab::server
