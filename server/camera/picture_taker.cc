#include "server/camera/picture_taker.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace faultlab::server {

PictureTaker::PictureTaker(Parts parts) : parts_(std::move(parts)), thread_([this] { Loop(); }) {}

PictureTaker::~PictureTaker() {
  Stop();
}

void PictureTaker::Note(PictureMoment moment) {
  if (!parts_.cameras.Has(moment.rig)) return;
  {
    const std::lock_guard lock(mutex_);
    if (stop_ || queue_.size() >= kWaitingMax) return;
    queue_.push_back({std::move(moment), parts_.clock.Monotonic(), 0, {}});
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
    const auto due = std::ranges::min_element(queue_, {}, &Noted::due);
    if (due->due > parts_.clock.Monotonic()) {
      const auto others = [this, waiting = queue_.size()] {
        return stop_ || queue_.size() != waiting;
      };
      parts_.clock.WaitUntil(lock, changed_, due->due, others);
      continue;
    }
    Noted noted = std::move(*due);
    queue_.erase(due);
    lock.unlock();
    bool again = false;
    try {
      again = Take(noted);
    } catch (const std::exception& error) {
      parts_.log("picture of run " + noted.moment.run + ": " + error.what());
    }
    lock.lock();
    if (!again || stop_) continue;
    noted.due = parts_.clock.Monotonic() + std::chrono::seconds(1 << noted.tries);
    ++noted.tries;
    queue_.push_back(std::move(noted));
  }
}

bool PictureTaker::Take(const Noted& noted) {
  const PictureMoment& moment = noted.moment;
  const auto room = parts_.store.HasRoom(moment.run, moment.why);
  if (!room.ok() || !room.value() || !parts_.disk.Check().ok()) return false;
  const auto picture = parts_.cameras.Look(moment.rig, noted.at);  // it logs a failing camera
  if (!parts_.still_shown(moment)) return false;
  if (!picture.ok()) return moment.why == "end" && noted.tries + 1 < kEndTries;
  StoredPicture row;
  row.sample = moment.sample;
  row.why = moment.why;
  row.content_type = picture.value()->content_type;
  const core::Status stored = parts_.store.Add(moment.run, row, picture.value()->bytes);
  const bool expected = stored.ok() || stored.error().code == core::ErrorCode::kConflict ||
                        stored.error().code == core::ErrorCode::kNotFound;
  if (!expected) parts_.log("picture of run " + moment.run + ": " + stored.error().message);
  return false;
}

}  // namespace faultlab::server
