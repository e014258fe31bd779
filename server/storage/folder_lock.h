#pragma once

#include <string>

#include "core/types/result.h"

namespace faultlab::server {

/// Allows one server per database file: an exclusive lock, held by this object. The kernel releases
/// it when the process dies for any reason.
class FolderLock {
 public:
  /// Locks a file at `path`, which is made when it is missing. Links are followed, so that one file
  /// is locked only once, under whatever names. kConflict when another process holds it (the
  /// message has its process id), kUnavailable when the file cannot be made.
  static core::Result<FolderLock> Take(const std::string& path);

  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  ~FolderLock();

 private:
  explicit FolderLock(int fd) : fd_(fd) {}
  int fd_ = -1;
};

}  // namespace faultlab::server
