#include "hardware/lcm/board_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>

#include "hardware/lcm/epoch_file.h"

namespace faultlab::hardware {
namespace {

/// Empty: the board has no node here, or one (of a serial line) whose opening may reset the device.
std::string NodeOf(const BenchFile& file) {
  return file.driver == BenchFile::Driver::kComedi ? file.comedi.device : std::string();
}

}  // namespace

core::Result<BoardLock> BoardLock::Take(const BenchFile& file, const std::string& state_directory) {
  if (file.driver == BenchFile::Driver::kSimulated) return BoardLock(-1);
  const std::string node = NodeOf(file);
  std::string path = node;
  if (node.empty()) {
    const std::string folder = StateDirectory(state_directory);
    std::error_code failed;
    std::filesystem::create_directories(folder, failed);
    path = folder + "/" + file.config.description.id + ".lock";
  }
  const int flags = node.empty() ? O_RDWR | O_CREAT : O_RDONLY | O_NONBLOCK | O_NOCTTY;
  const int opened = ::open(path.c_str(), flags | O_CLOEXEC, 0600);
  if (opened < 0) return BoardLock(-1);
  BoardLock lock(opened);
  if (::flock(opened, LOCK_EX | LOCK_NB) == 0) return lock;
  return core::Error{.code = core::ErrorCode::kConflict,
                     .message = "another faultlab rig has the board (" + path +
                                "): stop it first, for example with systemctl stop faultlab-rig",
                     .field = {}};
}

BoardLock::~BoardLock() {
  if (file_ >= 0) ::close(file_);
}

}  // namespace faultlab::hardware
