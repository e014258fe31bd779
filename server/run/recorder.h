#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/types/sample.h"
#include "server/run/backlog.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

/// Writes recordings asynchronously: one thread, one bounded queue for each run. Nothing is ever
/// dropped. While the database is busy or away, each run's data goes to its Backlog, and from there
/// into the database later, in order. If a run's queue and backlog are full, or the store refuses,
/// the run gets an error and must end.
class Recorder {
 public:
  static constexpr std::size_t kQueuedMax = 64;  ///< chunks and event lists per run

  /// @param folder  of the backlogs; empty: there are none, and the queue alone is the buffer
  /// @param room    see RunManagerOptions
  Recorder(RecordingStore& store,
           std::string folder,
           std::function<core::Status()> room,
           std::function<void(std::string_view)> log);
  ~Recorder();  ///< writes the queued data first; to the backlogs if the database is away
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// The behaviour when the queue of the run is full.
  enum class WhenFull { kFail, kWait };

  /// False: the queue is full or an earlier write failed; Drain returns which.
  bool Append(const std::string& run, std::vector<core::Sample> samples, WhenFull when_full);
  bool Append(const std::string& run, std::vector<RecordedEvent> events, WhenFull when_full);
  /// Waits until the run's data is stored, however long the database is away; not for long when
  /// the process ends: see Leave.
  /// @param end  as it will be stored: kept with the data for the next process
  /// @returns the first failure, or Done
  core::Status Drain(const std::string& run, const RunEnd& end);
  /// For an end that the database has not taken: keeps it for the next process. The caller tries
  /// again.
  void KeepEnd(const std::string& run, const RunEnd& end);
  /// Waits before another try. False: the process ends, and the next one stores what was kept.
  bool WaitToTryAgain(std::chrono::milliseconds patience);
  /// The end is stored, or never can be.
  void Forget(const std::string& run);
  /// Ends a run that has no thread of its own: it was not begun, or its Begin had no answer. Tried
  /// until it is stored or there is no such run.
  void EndLater(const std::string& run, const RunEnd& end);
  /// The process ends: from `patience` on nobody waits for a database that is away.
  void Leave(std::chrono::milliseconds patience);

 private:
  using Part = Backlog::Part;
  struct Item {
    std::string run;
    Part part;
  };
  struct Book {
    std::size_t queued = 0;
    std::size_t aside = 0;  ///< parts of the backlog that are not stored, without the end
    std::string failure;
    bool refused = false;     ///< the store takes no more of this run
    std::int64_t events = 0;  ///< number of events so far
    std::optional<Backlog> backlog;
    std::optional<RunEnd> end;
  };
  bool Enqueue(const std::string& run, Part part, WhenFull when_full);
  bool PutAside(const std::string& run, Book& book, const Part& part);
  bool MakeBacklog(const std::string& run, Book& book);
  void PutAllAside();
  void Loop();
  bool WriteNext(std::unique_lock<std::mutex>& lock);
  void StoreEnds(std::unique_lock<std::mutex>& lock);
  std::map<std::string, Book>::iterator NextBehind();
  core::Status Write(const std::string& run, const Part& part);
  bool Left() const;

  RecordingStore& store_;
  const std::string folder_;
  const std::function<core::Status()> room_;
  const std::function<void(std::string_view)> log_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> queue_;
  std::map<std::string, Book> books_;
  std::map<std::string, RunEnd> ends_;  ///< of EndLater
  std::string behind_;                  ///< the run whose backlog was written from last
  bool away_ = false;                   ///< the database did not take the last write
  std::optional<std::chrono::steady_clock::time_point> leave_at_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace faultlab::server
