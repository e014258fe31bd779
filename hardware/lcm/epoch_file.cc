#include "hardware/lcm/epoch_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "core/types/check.h"

namespace faultlab::hardware {
namespace {

core::Error NotKept(const std::string& path) {
  return {
      .code = core::ErrorCode::kUnavailable,
      .message = "the agent cannot keep the rig's epoch in " + path + ": " + std::strerror(errno),
      .field = {}};
}

bool WriteAndSync(const std::string& path, const std::string& line) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0) return false;
  const bool written = ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const bool synced = written && ::fsync(file) == 0;
  return ::close(file) == 0 && synced;
}

/// A new name is on the disk only when its folder is.
bool SyncFolder(const std::string& path) {
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return false;
  const bool synced = ::fsync(folder) == 0;
  return ::close(folder) == 0 && synced;
}

}  // namespace

std::string StateDirectory(const std::string& directory) {
  if (!directory.empty()) return directory;
  const char* home = std::getenv("HOME");
  return std::string(home != nullptr ? home : ".") + "/.faultlab/state";
}

core::Result<EpochFile> EpochFile::Open(const std::string& directory, const std::string& rig) {
  const std::string path = StateDirectory(directory) + "/" + rig + ".epoch";
  std::error_code unknown;
  if (!std::filesystem::exists(path, unknown) && !unknown) return EpochFile(path, {});
  std::ifstream file(path);
  SeenLease seen;
  const bool read = file >> seen.epoch && file.get() == ' ' && std::getline(file, seen.holder);
  if (read && !file.eof() && seen.epoch > 0 && !seen.holder.empty()) return EpochFile(path, seen);
  return core::Error{.code = core::ErrorCode::kInvalid,
                     .message = path + " does not hold the rig's epoch and its holder; when its " +
                                "content is lost, delete it: the next lease is taken as it comes",
                     .field = "state"};
}

core::Status EpochFile::Raise(SeenLease lease) {
  LAB_CHECK(lease.epoch >= seen_.epoch, lease.epoch, seen_.epoch);
  if (stored_ && lease == seen_) return core::Done{};
  seen_ = std::move(lease);
  const core::Status written = Write();
  stored_ = written.ok();
  return written;
}

core::Status EpochFile::Write() const {
  const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  const std::string next = path_ + ".new";
  const std::string line = std::to_string(seen_.epoch) + " " + seen_.holder + "\n";
  if (!WriteAndSync(next, line)) return NotKept(path_);
  if (std::rename(next.c_str(), path_.c_str()) != 0) return NotKept(path_);
  if (!SyncFolder(folder.string())) return NotKept(path_);
  return core::Done{};
}

}  // namespace faultlab::hardware
