#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/clock.h"
#include "server/run/run_recovery.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

/// Runs on far rigs whose server died: their rest is read from the rig when it is heard again, and
/// before a new run on the rig overwrites it. A rig that is not heard for three minutes, or has
/// begun another run or started anew, is not waited for: the recording stays as it is. Thread-safe;
/// own thread.
class RecoveryService {
 public:
  using FindRig = std::function<std::shared_ptr<hardware::Rig>(const std::string& id)>;
  /// Whether this server reads the rest of this run, and none of the others of its database.
  using IsOurs = std::function<bool(const RunRecord& record)>;
  /// Ends what this rig still plays: nobody could stop it, and nobody answers for it.
  using EndRun = std::function<void(const std::string& rig)>;

  RecoveryService(RecordingStore& store,
                  const Clock& clock,
                  FindRig find_rig,
                  std::function<void(std::string_view)> log);
  ~RecoveryService();  ///< Stop()

  void Start(IsOurs is_ours, EndRun end_run);
  /// What is not read yet is read by the next start.
  void Stop();
  /// Waits until nothing is missing of the runs of this rig. kUnavailable after `patience`.
  core::Status Await(const std::string& rig, std::chrono::milliseconds patience);

 private:
  struct Reading {
    std::unique_ptr<RunRecovery> rest;
    MonotonicTime stored_at;  ///< when the store last took something
  };
  void Loop();
  void Look();
  bool Begin(const RunRecord& record);
  void Step();
  void GiveUp(const RunRecord& record, const std::string& why);
  std::set<std::string> RigsWaiting() const;

  RecordingStore& store_;
  const Clock& clock_;
  const FindRig find_rig_;
  const std::function<void(std::string_view)> log_;
  IsOurs is_ours_;
  EndRun end_run_;

  // Of the thread.
  std::map<std::string, Reading> readings_;             ///< by run
  std::map<std::string, MonotonicTime> waiting_since_;  ///< by run
  std::vector<RunRecord> waiting_;                      ///< cannot be read now
  MonotonicTime looked_at_{};

  std::mutex mutex_;
  std::condition_variable changed_;
  bool stopping_ = false;
  std::int64_t looks_wanted_ = 1;
  std::int64_t looks_done_ = 0;
  std::set<std::string> rigs_;  ///< with a run whose rest is missing
  std::thread thread_;
};

}  // namespace faultlab::server
