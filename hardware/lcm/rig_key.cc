#include "hardware/lcm/rig_key.h"

#include <fcntl.h>
#include <sodium.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/types/check.h"

namespace faultlab::hardware {
namespace {

void UseSodium() {
  static const bool ready = sodium_init() >= 0;
  LAB_CHECK(ready);
}

core::Error Unreadable(const std::string& path, const std::string& why) {
  return {.code = core::ErrorCode::kInvalid, .message = path + ": " + why, .field = "keys"};
}

}  // namespace

Mac ComputeMac(const RigKey& key, std::span<const std::uint8_t> bytes) {
  Mac mac;
  crypto_generichash(mac.data(), mac.size(), bytes.data(), bytes.size(), key.data(), key.size());
  return mac;
}

bool SameMac(const Mac& a, const Mac& b) {
  return sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

bool CarriesMac(std::span<const std::uint8_t> bytes, const RigKey& key) {
  Mac claimed;
  if (bytes.size() <= claimed.size()) return false;
  const std::span<const std::uint8_t> tail = bytes.last(claimed.size());
  std::copy(tail.begin(), tail.end(), claimed.begin());
  return SameMac(claimed, ComputeMac(key, bytes.first(bytes.size() - tail.size())));
}

std::string KeyDirectory(const std::string& directory) {
  if (!directory.empty()) return directory;
  const char* home = std::getenv("HOME");
  return std::string(home != nullptr ? home : ".") + "/.faultlab/keys";
}

core::Result<std::optional<RigKey>> LoadRigKey(const std::string& directory,
                                               const std::string& rig) {
  const std::string path = KeyDirectory(directory) + "/" + rig + ".key";
  std::ifstream file(path);
  if (!file) return std::optional<RigKey>();
  std::string hex;
  file >> hex;
  RigKey key;
  std::size_t length = 0;
  const char* end = nullptr;
  const bool decoded =
      sodium_hex2bin(key.data(), key.size(), hex.c_str(), hex.size(), nullptr, &length, &end) == 0;
  if (!decoded || length != key.size() || end != hex.c_str() + hex.size()) {
    return Unreadable(path, "a key is 64 hex digits");
  }
  return std::optional<RigKey>(key);
}

core::Result<RigKey> LoadOrMakeRigKey(const std::string& directory, const std::string& rig) {
  UseSodium();
  TRY(auto known, LoadRigKey(directory, rig));
  if (known) return *known;
  const std::string folder = KeyDirectory(directory);
  const std::string path = folder + "/" + rig + ".key";
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  RigKey key;
  randombytes_buf(key.data(), key.size());
  std::array<char, 65> hex;
  sodium_bin2hex(hex.data(), hex.size(), key.data(), key.size());
  const std::string line = std::string(hex.data()) + "\n";
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) return Unreadable(path, "cannot be made");
  const bool written = ::write(file, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  if (::close(file) != 0 || !written) return Unreadable(path, "cannot be written");
  return key;
}

std::int64_t RandomId() {
  UseSodium();
  std::int64_t id = 0;
  randombytes_buf(&id, sizeof id);
  return id & 0x7fffffffffffffff;
}

}  // namespace faultlab::hardware
