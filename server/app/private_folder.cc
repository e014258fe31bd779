#include "server/app/private_folder.h"

#include <filesystem>

namespace faultlab::server {
namespace {

namespace fs = std::filesystem;

constexpr fs::perms kOthers = fs::perms::group_all | fs::perms::others_all;

void TakeFromOthers(const fs::path& path, const std::function<void(std::string_view)>& warn) {
  std::error_code ec;
  const fs::perms rights = fs::status(path, ec).permissions();
  if (ec || (rights & kOthers) == fs::perms::none) return;
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
  const fs::path database = path / "faultlab.db";
  if (is_new) {
    fs::permissions(path, fs::perms::owner_all, ec);
  } else if (fs::exists(database, ec)) {
    TakeFromOthers(path, warn);
  }
  for (const char* end : {"", "-wal", "-shm", ".lock"}) {
    const fs::path file = database.string() + end;
    if (fs::exists(file, ec)) TakeFromOthers(file, warn);
  }
  return core::Done{};
}

}  // namespace faultlab::server
