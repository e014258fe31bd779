#pragma once

#include <chrono>
#include <string>

namespace faultlab::server {

/// A camera that looks at a bench: [[camera]]. Only the server's configuration names cameras; a rig
/// cannot announce one, or its agent could send this server to any address.
struct CameraSettings {
  std::string rig;       ///< RigDescription::id
  std::string snapshot;  ///< address of its newest picture; see CameraReader::CheckAddress
  std::chrono::milliseconds timeout{2'000};  ///< of one request
};

}  // namespace faultlab::server
