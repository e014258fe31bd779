#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/camera/camera_picture.h"
#include "server/camera/camera_settings.h"
#include "server/clock.h"
#include "server/web_client/web_client.h"

namespace faultlab::server {

/// The cameras of the benches. A camera is asked only when somebody looks: one request at a time
/// for each camera, and all who look within `shared_for` get the same picture.
///
///   viewers --Look--> CameraReader --GET, one at a time--> the camera's snapshot address
///
/// Thread-safe.
class CameraReader {
 public:
  struct Limits {
    std::chrono::milliseconds shared_for{300};  ///< how long a picture is given to others, too
    std::chrono::milliseconds pause{1'000};     ///< before a camera that failed is asked again
    std::size_t bytes_max = 2 << 20;            ///< of one picture
  };
  /// @param log  gets a line when a camera begins to fail and when it works again; may be empty
  CameraReader(const std::vector<CameraSettings>& cameras,
               const Clock& clock,
               Limits limits,
               std::function<void(std::string_view)> log);
  ~CameraReader();
  CameraReader(const CameraReader&) = delete;
  CameraReader& operator=(const CameraReader&) = delete;

  bool Has(std::string_view rig) const { return cameras_.contains(rig); }
  /// The picture of this rig's camera, asked for not before `after`: a failure from before it does
  /// not count either. Blocks for up to the camera's timeout, or twice that if somebody else's
  /// request is under way: on pool threads only.
  /// kNotFound: the rig has no camera. kUnavailable: the camera gave no picture.
  core::Result<SharedPicture> Look(std::string_view rig,
                                   MonotonicTime after = MonotonicTime::min());

  /// Whether a camera may have this address. kInvalid with what is expected if not.
  static core::Status CheckAddress(const std::string& url);

 private:
  struct Camera;
  core::Result<SharedPicture> Fetch(const Camera& camera) const;
  void Tell(const Camera& camera, const core::Result<SharedPicture>& fetched) const;

  const Clock& clock_;
  const Limits limits_;
  const std::function<void(std::string_view)> log_;
  std::map<std::string, std::unique_ptr<Camera>, std::less<>> cameras_;  ///< by rig; fixed
};

}  // namespace faultlab::server
