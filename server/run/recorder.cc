#include "server/run/recorder.h"

#include <chrono>
#include <utility>

#include "server/storage/database_error.h"

namespace faultlab::server {
namespace {

/// A restart of the database takes a second or two. The queue of a run in real time holds a minute.
constexpr std::chrono::seconds kOutageMax{30};
constexpr std::chrono::milliseconds kNextTry{250};

}  // namespace

Recorder::Recorder(RecordingStore& store) : store_(store), thread_([this] { Loop(); }) {}

Recorder::~Recorder() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool Recorder::Append(const std::string& run,
                      std::vector<core::Sample> samples,
                      WhenFull when_full) {
  return samples.empty() || Enqueue({run, std::move(samples), {}}, when_full);
}

bool Recorder::Append(const std::string& run,
                      std::vector<RecordedEvent> events,
                      WhenFull when_full) {
  return events.empty() || Enqueue({run, {}, std::move(events)}, when_full);
}

bool Recorder::Enqueue(Item item, WhenFull when_full) {
  std::unique_lock lock(mutex_);
  Book& book = books_[item.run];
  if (when_full == WhenFull::kWait) {
    changed_.wait(lock, [&] { return book.queued < kQueuedMax || !book.failure.empty(); });
  }
  if (!book.failure.empty()) return false;
  if (book.queued >= kQueuedMax) {
    book.failure = "The disk is slower than the experiment: the recording has a hole.";
    return false;
  }
  ++book.queued;
  queue_.push_back(std::move(item));
  lock.unlock();
  changed_.notify_all();
  return true;
}

core::Status Recorder::Write(const Item& item, std::int64_t events_before) {
  if (!item.samples.empty()) {
    return store_.AppendChunk(item.run, item.samples.front().index, item.samples);
  }
  return store_.AppendEvents(item.run, item.events, events_before);
}

core::Status Recorder::WriteInTime(const Item& item, std::int64_t events_before) {
  const auto give_up = std::chrono::steady_clock::now() + kOutageMax;
  for (;;) {
    core::Status status = Write(item, events_before);
    const bool again = !status.ok() && MayPass(status.error());
    if (!again || std::chrono::steady_clock::now() >= give_up) return status;
    std::unique_lock lock(mutex_);
    if (changed_.wait_for(lock, kNextTry, [this] { return stop_; })) return status;
  }
}

void Recorder::Loop() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stop_ || !queue_.empty(); });
    if (queue_.empty()) return;
    const Item item = std::move(queue_.front());
    queue_.pop_front();
    const bool failed = !books_[item.run].failure.empty();
    const std::int64_t events_before = books_[item.run].events;
    lock.unlock();
    core::Status status = core::Done{};
    if (!failed) status = WriteInTime(item, events_before);
    lock.lock();
    Book& book = books_[item.run];
    --book.queued;
    if (status.ok()) book.events += static_cast<std::int64_t>(item.events.size());
    if (!status.ok() && book.failure.empty()) book.failure = status.error().message;
    changed_.notify_all();
  }
}

core::Status Recorder::Drain(const std::string& run) {
  std::unique_lock lock(mutex_);
  const auto book = books_.find(run);
  if (book == books_.end()) return core::Done{};
  changed_.wait(lock, [&] { return book->second.queued == 0; });
  const std::string failure = std::move(book->second.failure);
  books_.erase(book);
  if (failure.empty()) return core::Done{};
  return core::Error{core::ErrorCode::kUnavailable, failure, {}};
}

}  // namespace faultlab::server
