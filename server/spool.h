#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/types/result.h"
#include "server/disk_reserve.h"

namespace faultlab::server {

/// The bytes of an answer that may be large: a few are in memory, more in a file without a name,
/// which ends with this object or with the process. One thread at a time.
class Spool {
 public:
  static constexpr std::size_t kMemoryMax = 256 << 10;

  /// @param disk  the disk of such a file; its reserve stays free
  explicit Spool(DiskReserve disk) : disk_(std::move(disk)) {}
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  void Append(std::string_view bytes);
  /// Reserves bytes that WriteAt writes later. @returns their offset
  std::uint64_t Reserve(std::uint64_t bytes);
  /// Contract: within size().
  void WriteAt(std::uint64_t offset, std::string_view bytes);
  std::uint64_t size() const { return size_; }

  /// To be checked at the end: kUnavailable when the disk did not accept all bytes.
  const core::Status& status() const { return status_; }
  bool in_memory() const { return fd_ < 0; }
  /// Contract: in_memory().
  std::string TakeMemory() && { return std::move(memory_); }
  /// At most `bytes_max` bytes from `offset`; nothing on a read error.
  std::optional<std::string> Read(std::uint64_t offset, std::size_t bytes_max) const;

 private:
  void OpenFile();
  void Write(std::uint64_t offset, std::string_view bytes);
  void Fail(int error);

  const DiskReserve disk_;
  std::string memory_;  ///< with a file: the last bytes, not yet written
  int fd_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t written_ = 0;  ///< to the file
  core::Status status_ = core::Done{};
};

}  // namespace faultlab::server
