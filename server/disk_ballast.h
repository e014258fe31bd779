#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/disk_reserve.h"
#include "server/repeated.h"

namespace faultlab::server {

/// A file that takes up space on a disk, and is deleted when somebody else has filled the disk, so
/// that sessions can be ended, recordings deleted, and people can sign in. It is made again when
/// there is space.
class DiskBallast {
 public:
  /// @param disk  an eighth of its reserve is the size of the file, at most 16 MB
  DiskBallast(const DiskReserve& disk, std::function<void(std::string_view)> log);
  ~DiskBallast();  ///< deletes the file
  DiskBallast(const DiskBallast&) = delete;
  DiskBallast& operator=(const DiskBallast&) = delete;

  /// kUnavailable "disk_full" while the file is given up.
  core::Status Check() const;
  /// What recordings in progress must leave free: kUnavailable "disk_full" below it.
  core::Status CheckForRecording() const;

 private:
  void Tend();
  bool Make();

  const std::string folder_;
  const std::int64_t bytes_;
  const std::string path_;
  const std::function<void(std::string_view)> log_;
  std::atomic<bool> there_{false};
  std::optional<Repeated> looks_;
};

}  // namespace faultlab::server
