#include "server/camera/camera_reader.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;
using Outcome = core::Result<SharedPicture>;

constexpr int kOk = 200;

WebClientOptions ClientOptions(std::chrono::milliseconds timeout, std::size_t bytes_max) {
  return {.insecure_local = true,
          .connect_deadline = timeout,
          .deadline = timeout,
          .bytes_max = bytes_max};
}

Error NoPicture(std::string why) {
  return {ErrorCode::kUnavailable, std::move(why), "", "camera_silent"};
}

}  // namespace

struct CameraReader::Camera {
  Camera(const CameraSettings& settings, const Limits& limits)
      : rig(settings.rig),
        url(settings.snapshot),
        client(ClientOptions(settings.timeout, limits.bytes_max)) {}

  const std::string rig;
  const std::string url;
  const WebClient client;
  std::mutex mutex;
  std::condition_variable answered;
  bool asking = false;
  MonotonicTime asked_at{};      ///< the newest request
  SharedPicture picture;         ///< the newest; null before the first
  std::optional<Error> failure;  ///< of the last request; empty when it succeeded
  MonotonicTime failed_at{};
};

std::string_view PictureType(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xD8\xFF")) return "image/jpeg";
  if (bytes.starts_with("\x89PNG\r\n\x1A\n")) return "image/png";
  return {};
}

CameraReader::CameraReader(const std::vector<CameraSettings>& cameras,
                           const Clock& clock,
                           Limits limits,
                           std::function<void(std::string_view)> log)
    : clock_(clock), limits_(limits), log_(std::move(log)) {
  for (const CameraSettings& settings : cameras) {
    cameras_[settings.rig] = std::make_unique<Camera>(settings, limits_);
  }
}

CameraReader::~CameraReader() = default;

core::Status CameraReader::CheckAddress(const std::string& url) {
  if (WebClient({.insecure_local = true}).CheckUrl(url).ok()) return core::Done{};
  return Error{ErrorCode::kInvalid,
               "must be the address of a picture: http://.. on this machine or in the local "
               "network (127.0.0.1, 10.0.0.7, [fd00::7], camera.local), or https://.., without a "
               "password",
               "",
               "internal"};
}

core::Result<SharedPicture> CameraReader::Look(std::string_view rig, MonotonicTime after) {
  const auto found = cameras_.find(rig);
  if (found == cameras_.end()) {
    return core::Refuse("no_camera");
  }
  Camera& camera = *found->second;
  std::unique_lock lock(camera.mutex);
  for (;;) {
    const MonotonicTime now = clock_.Monotonic();
    const SharedPicture& newest = camera.picture;
    if (newest && newest->asked >= after && now - newest->arrived < limits_.shared_for) {
      return newest;
    }
    const bool failed = camera.failure && camera.asked_at >= after;
    if (failed && now - camera.failed_at < limits_.pause) return *camera.failure;
    if (!camera.asking) break;
    camera.answered.wait(lock, [&camera] { return !camera.asking; });
  }
  camera.asking = true;
  camera.asked_at = clock_.Monotonic();
  lock.unlock();
  Outcome fetched = NoPicture("The request for a picture failed.");
  try {
    fetched = Fetch(camera);
  } catch (const std::exception&) {
    // No memory for a picture: the same as no picture.
  }
  lock.lock();
  Tell(camera, fetched);
  camera.asking = false;
  camera.failure.reset();
  if (fetched.ok()) {
    camera.picture = fetched.value();
  } else {
    camera.picture.reset();
    camera.failure = fetched.error();
    camera.failed_at = clock_.Monotonic();
  }
  camera.answered.notify_all();
  return fetched;
}

core::Result<SharedPicture> CameraReader::Fetch(const Camera& camera) const {
  auto picture = std::make_shared<CameraPicture>();
  picture->asked = clock_.Monotonic();
  auto answer = camera.client.Ask({camera.url, {}});
  picture->arrived = clock_.Monotonic();
  if (!answer.ok()) {
    const bool large = answer.error().code == ErrorCode::kTooLarge;
    return NoPicture(large ? "The camera's picture is too large." : "The camera does not answer.");
  }
  if (answer.value().status != kOk) {
    return NoPicture("The camera answers with status " + std::to_string(answer.value().status) +
                     ".");
  }
  picture->bytes = std::move(answer).value().body;
  picture->content_type = PictureType(picture->bytes);
  if (picture->content_type.empty()) {
    return NoPicture("The camera's answer is neither JPEG nor PNG.");
  }
  return SharedPicture(std::move(picture));
}

/// Called with the camera's mutex held, before the outcome is kept.
void CameraReader::Tell(const Camera& camera, const Outcome& fetched) const {
  if (!log_ || fetched.ok() == !camera.failure.has_value()) return;
  log_("camera of " + camera.rig + " (" + camera.url +
       "): " + (fetched.ok() ? "works again" : fetched.error().message));
}

}  // namespace faultlab::server
