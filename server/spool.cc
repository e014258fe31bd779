#include "server/spool.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>

#include "core/types/check.h"

namespace faultlab::server {

Spool::~Spool() {
  if (fd_ >= 0) ::close(fd_);
}

void Spool::Fail(int error) {
  if (!status_.ok()) return;
  const char* what = error == ENOSPC || error == EDQUOT
                         ? "The server's disk is full; ask its operator to free space."
                         : "The server's disk does not take the file; tell its operator.";
  status_ = core::Error{core::ErrorCode::kUnavailable, what, "", "disk_full"};
}

void Spool::OpenFile() {
  std::string path = (disk_.folder.empty() ? "." : disk_.folder) + "/answer-XXXXXX";
  fd_ = ::mkostemp(path.data(), O_CLOEXEC);
  if (fd_ < 0) return Fail(errno);
  ::unlink(path.c_str());
}

void Spool::Write(std::uint64_t offset, std::string_view bytes) {
  while (!bytes.empty() && status_.ok()) {
    const ssize_t wrote = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) return Fail(wrote < 0 ? errno : ENOSPC);
    offset += static_cast<std::uint64_t>(wrote);
    bytes.remove_prefix(static_cast<std::size_t>(wrote));
  }
}

void Spool::Append(std::string_view bytes) {
  if (!status_.ok()) return;
  size_ += bytes.size();
  memory_ += bytes;
  if (memory_.size() <= kMemoryMax) return;
  status_ = disk_.Check();
  if (status_.ok() && fd_ < 0) OpenFile();
  Write(written_, memory_);
  written_ += memory_.size();
  memory_.clear();
}

std::uint64_t Spool::Reserve(std::uint64_t bytes) {
  const std::uint64_t at = size_;
  constexpr std::uint64_t kZeros = 64 << 10;
  while (bytes > 0 && status_.ok()) {
    const std::uint64_t piece = std::min(bytes, kZeros);
    Append(std::string(piece, '\0'));
    bytes -= piece;
  }
  return at;
}

void Spool::WriteAt(std::uint64_t offset, std::string_view bytes) {
  if (!status_.ok()) return;
  LAB_CHECK(offset + bytes.size() <= size_, offset, bytes.size(), size_);
  if (offset < written_) {
    const std::size_t in_file = std::min<std::uint64_t>(bytes.size(), written_ - offset);
    Write(offset, bytes.substr(0, in_file));
    offset += in_file;
    bytes.remove_prefix(in_file);
  }
  if (bytes.empty()) return;
  memory_.replace(offset - written_, bytes.size(), bytes);
}

std::optional<std::string> Spool::Read(std::uint64_t offset, std::size_t bytes_max) const {
  if (offset >= written_) {
    return memory_.substr(std::min<std::uint64_t>(offset - written_, memory_.size()), bytes_max);
  }
  std::string bytes(std::min<std::uint64_t>(bytes_max, written_ - offset), '\0');
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t read =
        ::pread(fd_, bytes.data() + got, bytes.size() - got, static_cast<off_t>(offset + got));
    if (read < 0 && errno == EINTR) continue;
    if (read <= 0) return std::nullopt;
    got += static_cast<std::size_t>(read);
  }
  return bytes;
}

}  // namespace faultlab::server
