#include "server/storage/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace faultlab::server {
namespace {

std::string Reason() {
  return std::generic_category().message(errno);
}

/// The text that the holder wrote into the file: its process id.
std::string HolderOf(int fd) {
  std::array<char, 20> text{};
  const ssize_t size = pread(fd, text.data(), text.size(), 0);
  std::string digits(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  digits.resize(std::min(digits.size(), digits.find_first_not_of("0123456789")));
  return digits.empty() ? "unknown" : digits;
}

}  // namespace

core::Result<FolderLock> FolderLock::Take(const std::string& path) {
  FolderLock lock(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (lock.fd_ < 0) {
    return core::Error{core::ErrorCode::kUnavailable, "cannot open " + path + ": " + Reason(), ""};
  }
  if (flock(lock.fd_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) {
      return core::Error{
          core::ErrorCode::kUnavailable, "cannot lock " + path + ": " + Reason(), ""};
    }
    return core::Error{core::ErrorCode::kConflict,
                       "another server (process " + HolderOf(lock.fd_) + ") holds " + path +
                           "; stop it, or give this one a data folder of its own",
                       "data_dir"};
  }
  const std::string self = std::to_string(getpid()) + "\n";
  // The lock is valid also without this text, which is for people (the disk may be full).
  if (ftruncate(lock.fd_, 0) == 0) (void)!pwrite(lock.fd_, self.data(), self.size(), 0);
  return lock;
}

FolderLock::FolderLock(FolderLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

FolderLock::~FolderLock() {
  if (fd_ >= 0) close(fd_);
}

}  // namespace faultlab::server
