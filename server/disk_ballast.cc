#include "server/disk_ballast.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <utility>

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kBytesMax = 16 << 20;
constexpr std::int64_t kShareOfReserve = 8;
constexpr std::int64_t kForRecordings = 4;  ///< times its size must be free
constexpr std::chrono::milliseconds kEvery{500};

core::Error Full() {
  return {core::ErrorCode::kUnavailable,
          "The server's disk is full: nothing is recorded; tell its operator.",
          "",
          "disk_full"};
}

}  // namespace

DiskBallast::DiskBallast(const DiskReserve& disk, std::function<void(std::string_view)> log)
    : folder_(disk.folder),
      bytes_(std::min(kBytesMax, disk.bytes / kShareOfReserve)),
      path_((fs::path(disk.folder) / "faultlab.ballast").string()),
      log_(std::move(log)) {
  if (folder_.empty() || bytes_ == 0) return;
  Tend();
  looks_.emplace(kSystemClock, Repeated::First::kAfterAPause, kEvery, [this] { Tend(); });
}

DiskBallast::~DiskBallast() {
  if (!looks_) return;
  looks_.reset();
  ::unlink(path_.c_str());
}

void DiskBallast::Tend() {
  std::error_code ec;
  const auto space = fs::space(folder_, ec);
  if (ec) return;
  const auto free = static_cast<std::int64_t>(space.available);
  if (there_ && free < bytes_ / 2) {
    ::unlink(path_.c_str());
    there_ = false;
    log_("the disk of " + folder_ + " is full: recordings end, sessions can be ended");
  } else if (!there_ && free > kForRecordings * bytes_) {
    there_ = Make();
  }
}

bool DiskBallast::Make() {
  const int fd = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return false;
  const bool made = ::posix_fallocate(fd, 0, bytes_) == 0;
  ::close(fd);
  if (!made) ::unlink(path_.c_str());
  return made;
}

core::Status DiskBallast::Check() const {
  if (folder_.empty() || bytes_ == 0 || there_) return core::Done{};
  return Full();
}

core::Status DiskBallast::CheckForRecording() const {
  if (folder_.empty() || bytes_ == 0) return core::Done{};
  const core::Status room = DiskReserve{folder_, kForRecordings * bytes_}.Check();
  if (room.ok()) return room;
  return Full();
}

}  // namespace faultlab::server
