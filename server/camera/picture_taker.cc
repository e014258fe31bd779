#include "server/camera/picture_taker.h"

#include <exception>
#include <utility>

namespace faultlab::server {

PictureTaker::PictureTaker(Parts parts) : parts_(std::move(parts)), thread_([this] { Loop(); }) {}

PictureTaker::~PictureTaker() {
  Stop();
}

void PictureTaker::Note(PictureMoment moment) {
  if (!parts_.desk.Has(moment.rig)) return;
  {
    const std::lock_guard lock(mutex_);
    if (stop_ || queue_.size() >= kWaitingMax) return;
    queue_.push_back({std::move(moment), parts_.clock.Monotonic()});
  }
  changed_.notify_all();
}

void PictureTaker::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    queue_.clear();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void PictureTaker::Loop() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || !queue_.empty(); });
    if (stop_) return;
    const Noted noted = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    try {
      Take(noted);
    } catch (const std::exception& error) {
      parts_.log("picture of run " + noted.moment.run + ": " + error.what());
    }
    lock.lock();
  }
}

void PictureTaker::Take(const Noted& noted) {
  const PictureMoment& moment = noted.moment;
  const auto room = parts_.store.HasRoom(moment.run, moment.why);
  if (!room.ok() || !room.value() || !parts_.disk.Check().ok()) return;
  const auto picture = parts_.desk.Look(moment.rig, noted.at);
  if (!picture.ok() || !parts_.still_shown(moment)) return;  // the desk logs a failing camera
  StoredPicture row;
  row.sample = moment.sample;
  row.why = moment.why;
  row.content_type = picture.value()->content_type;
  const core::Status stored = parts_.store.Add(moment.run, row, picture.value()->bytes);
  const bool expected = stored.ok() || stored.error().code == core::ErrorCode::kConflict ||
                        stored.error().code == core::ErrorCode::kNotFound;
  if (!expected) parts_.log("picture of run " + moment.run + ": " + stored.error().message);
}

}  // namespace faultlab::server
