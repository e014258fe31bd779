#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "server/camera/camera_reader.h"
#include "server/clock.h"
#include "server/disk_reserve.h"
#include "server/storage/picture_store.h"

namespace faultlab::server {

/// Something that a picture of the bench is stored for.
struct PictureMoment {
  std::string run;
  std::string rig;
  std::int64_t sample = 0;
  std::string why;  ///< StoredPicture::why
};

/// Takes pictures at moments of runs and stores them with the recordings, on a thread of its own: a
/// run never waits for a camera. A picture that fails, comes too late or has no room is left out;
/// that of the end, when nothing moves any more, is asked for again for half a minute.
///
///   runs --Note--> queue --> CameraReader::Look --> PictureStore::Add
class PictureTaker {
 public:
  static constexpr std::size_t kWaitingMax = 64;
  static constexpr int kEndTries = 6;  ///< after 1, 2, 4, 8 and 16 s

  struct Parts {
    CameraReader& cameras;
    PictureStore& store;
    const Clock& clock;
    DiskReserve disk;
    /// Whether the rig shows this run, or nothing: asked when the picture has come, before it is
    /// stored.
    std::function<bool(const PictureMoment&)> still_shown;
    std::function<void(std::string_view)> log;
  };
  explicit PictureTaker(Parts parts);
  ~PictureTaker();  ///< Stop()
  PictureTaker(const PictureTaker&) = delete;
  PictureTaker& operator=(const PictureTaker&) = delete;

  /// Any thread; does not block. No effect for a rig without a camera, or when kWaitingMax wait.
  void Note(PictureMoment moment);
  /// Finishes the picture in progress and drops those that wait.
  void Stop();

 private:
  struct Noted {
    PictureMoment moment;
    MonotonicTime at{};
    int tries = 0;
    MonotonicTime due{};
  };
  void Loop();
  /// Whether the camera gave nothing and is to be asked again.
  bool Take(const Noted& noted);

  const Parts parts_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Noted> queue_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace faultlab::server
