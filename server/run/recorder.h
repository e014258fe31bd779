#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "core/types/sample.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

/// Writes recordings asynchronously: one thread, one bounded queue for each run. Nothing is ever
/// dropped. If the database is busy or away, writing is tried again for half a minute; if a run's
/// queue is full or the store refuses, the run gets an error and must end.
class Recorder {
 public:
  static constexpr std::size_t kQueuedMax = 64;  ///< chunks and event lists per run

  explicit Recorder(RecordingStore& store);
  ~Recorder();  ///< writes the queued data first
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// The behaviour when the queue of the run is full.
  enum class WhenFull { kFail, kWait };

  /// False: the queue is full or an earlier write failed; Drain returns which.
  bool Append(const std::string& run, std::vector<core::Sample> samples, WhenFull when_full);
  bool Append(const std::string& run, std::vector<RecordedEvent> events, WhenFull when_full);
  /// Waits until the run's queue is stored, then removes the queue.
  /// @returns the first failure, or Done
  core::Status Drain(const std::string& run);

 private:
  struct Item {
    std::string run;
    std::vector<core::Sample> samples;
    std::vector<RecordedEvent> events;
  };
  struct Book {
    std::size_t queued = 0;
    std::string failure;
    std::int64_t events = 0;  ///< number of events stored
  };
  bool Enqueue(Item item, WhenFull when_full);
  void Loop();
  core::Status Write(const Item& item, std::int64_t events_before);
  core::Status WriteInTime(const Item& item, std::int64_t events_before);

  RecordingStore& store_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> queue_;
  std::unordered_map<std::string, Book> books_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace faultlab::server
