#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "hardware/rig.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

/// The rest of a run whose server died: what its rig still has is added to the recording, which
/// then ends as the rig says. Samples and events that are stored already are left out, so that this
/// may be cut off at any point and begun again. One thread.
class RunRecovery {
 public:
  /// @param record  RunRecord::AwaitsRecovery
  RunRecovery(std::shared_ptr<hardware::Rig> rig, RecordingStore& store, RunRecord record);

  const RunRecord& record() const { return record_; }
  /// The errors of Rig::Resume and of the store.
  core::Status Begin();
  /// Adds what has come meanwhile; waits for nothing. After an error the next call tries again.
  /// @returns true when the recording is closed
  core::Result<bool> Step();

 private:
  void Take(const core::Sample& sample);
  void Take(const hardware::RigEvent& event);
  core::Status Write();

  const std::shared_ptr<hardware::Rig> rig_;
  RecordingStore& store_;
  const RunRecord record_;
  std::multiset<std::string> stored_events_;  ///< JSON; each stands for one event of the rig
  bool end_stored_ = false;
  std::int64_t first_index_ = 0;  ///< of the rest
  std::int64_t next_index_ = 0;   ///< of the sample after the last one that is known
  std::int64_t fetched_ = 0;
  bool hole_ = false;                  ///< the rig has lost messages before the next sample
  std::vector<core::Sample> samples_;  ///< not stored yet
  std::vector<RecordedEvent> events_;
  RunState end_ = RunState::kInterrupted;
  bool read_ = false;  ///< the rig has nothing more to say
};

}  // namespace faultlab::server
