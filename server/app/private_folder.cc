#include "server/app/private_folder.h"

#include <filesystem>

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;

constexpr fs::perms kOthers = fs::perms::group_all | fs::perms::others_all;

bool OthersMayEnter(const fs::path& path) {
  std::error_code ec;
  const fs::perms rights = fs::status(path, ec).permissions();
  return !ec && (rights & kOthers) != fs::perms::none;
}

/// The folder is empty or contains something that faultlab wrote. The rights of other folders, such
/// as a home or /tmp, must not be changed.
bool IsOurs(const fs::path& folder) {
  std::error_code ec;
  bool empty = true;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ec)) {
    if (entry.path().filename().string().starts_with("faultlab.")) return true;
    empty = false;
  }
  return empty && !ec;
}

void TakeFromOthers(const fs::path& path, const std::function<void(std::string_view)>& warn) {
  if (!OthersMayEnter(path)) return;
  std::error_code ec;
  fs::permissions(path, kOthers, fs::perm_options::remove, ec);
  warn(path.string() + (ec ? " may be read by others, and this cannot be changed: " + ec.message()
                           : std::string(" could be read by others; now only by its owner")));
}

}  // namespace

core::Status MakePrivateFolder(const std::string& folder,
                               const std::function<void(std::string_view)>& warn) {
  std::error_code ec;
  const fs::path path(folder);
  const bool is_new = fs::create_directories(path, ec);
  if (ec) {
    return core::Error{core::ErrorCode::kUnavailable,
                       "cannot create the data folder '" + folder + "': " + ec.message(),
                       "data_dir"};
  }
  if (is_new) {
    fs::permissions(path, fs::perms::owner_all, ec);
  } else if (IsOurs(path)) {
    TakeFromOthers(path, warn);
  } else if (OthersMayEnter(path)) {
    warn(folder + " holds other files and is open to others: give faultlab a folder of its own");
  }
  const fs::path database = path / "faultlab.db";
  for (const char* end : {"", "-wal", "-shm", ".lock"}) {
    const fs::path file = database.string() + end;
    if (fs::exists(file, ec)) TakeFromOthers(file, warn);
  }
  return core::Done{};
}

}  // namespace faultlab::server
