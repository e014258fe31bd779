#include "hardware/lcm/key_ring.h"

#include <filesystem>

#include "hardware/lcm/rig_name.h"

namespace faultlab::hardware {
namespace {

constexpr Nanoseconds kReadEvery = std::chrono::seconds(2);

}  // namespace

std::optional<RigKey> KeyRing::Find(const std::string& rig, Nanoseconds now) {
  if (!read_at_ || now - *read_at_ >= kReadEvery) {
    read_at_ = now;
    Read();
  }
  const auto known = keys_.find(rig);
  return known == keys_.end() ? std::nullopt : std::optional(known->second);
}

void KeyRing::Read() {
  keys_.clear();
  std::error_code none;
  for (const auto& file : std::filesystem::directory_iterator(directory_, none)) {
    const std::string rig = file.path().stem();
    if (file.path().extension() != ".key" || !IsRigName(rig)) continue;
    // A file that is no key yet is being written, or is looked at again.
    const auto key = LoadRigKey(directory_, rig);
    if (key.ok() && key.value()) keys_[rig] = *key.value();
  }
}

}  // namespace faultlab::hardware
