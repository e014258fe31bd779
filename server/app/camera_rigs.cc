#include "server/app/camera_rigs.h"

#include "hardware/lcm/rig_key.h"

namespace faultlab::server {

core::Status CheckCameraRigs(const Config& config, const RigPool& rig_pool) {
  for (const CameraSettings& camera : config.cameras) {
    if (rig_pool.Find(camera.rig).ok()) continue;
    std::string why = "this server has no rig '" + camera.rig + "'";
    if (!config.lcm_url.empty()) {
      const std::string keys = hardware::KeyDirectory(config.lcm_keys);
      const auto key = hardware::LoadRigKey(keys, camera.rig);
      if (key.ok() && key.value()) continue;
      why += " and no key of it, " + keys + "/" + camera.rig + ".key";
    }
    return core::Error{core::ErrorCode::kInvalid, "camera: " + why, "camera"};
  }
  return core::Done{};
}

}  // namespace faultlab::server
