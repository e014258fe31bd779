#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <shared_mutex>
#include <span>
#include <string_view>
#include <vector>

#include "core/fingerprint/record_index.h"
#include "core/types/result.h"
#include "core/types/sample.h"
#include "server/auth/accounts.h"
#include "server/auth/principal.h"
#include "server/clock.h"
#include "server/course/assignments.h"
#include "server/course/blind_trials.h"
#include "server/course/trials.h"
#include "server/experiment/long_turn.h"
#include "server/storage/recording_store.h"

namespace faultlab::server::course {

/// While a blind exercise is open, the lab diagnoses none of its records, whoever brings it and
/// however it is dressed:
///
///   Trials, RecordingStore --sealed runs, also those that go on--> RecordIndex
///   what somebody brings --Find--> the trial of whose record it is a copy
///
/// What is sealed is read again before each search, so that every server of a lab knows the runs of
/// all; the noise of each is made once, some 5 ms for a run of 20 s, and kept in memory, 8 kB and,
/// where nobody else plays its voltages, 32 kB more. What is due is opened meanwhile. Searches that
/// take more than a second are made one at a time. Thread-safe.
class ExamRoom {
 public:
  struct Parts {
    Assignments& assignments;
    Trials& trials;
    BlindTrials& blind_trials;
    Accounts& accounts;
    RecordingStore& store;
    const Clock& clock;
    std::function<void(std::string_view)> log;
  };
  explicit ExamRoom(Parts parts) : parts_(std::move(parts)) {}

  /// Of whose records something that is sealed now is in what somebody brought. kConflict
  /// "exam_compares_less" where it is too long to be compared with all of them, kUnavailable
  /// LongTurn::kTaken while another one takes long.
  core::Result<std::vector<std::int64_t>> TrialsOf(std::span<const core::Sample> brought);
  /// kConflict "uploads_wait" for students of a course of which an exercise is open that says so.
  core::Status MayBring(const Principal& who);

 private:
  struct Known {
    std::int64_t samples = 0;
    bool whole = false;  ///< its run has ended
  };
  /// Reads what has come since the last time, and forgets what is released.
  core::Status CatchUp();
  /// A damaged record is passed over: it can be brought by nobody.
  core::Status CatchUpOn(const Trials::Sealed& trial);
  /// Opens it when it is due.
  bool IsOpened(const Trials::Sealed& trial, std::map<std::int64_t, Assignment>& assignments);

  Parts parts_;
  std::mutex catching_up_;                 ///< one at a time, while others search
  std::map<std::int64_t, Known> known_{};  ///< by trial; of who catches up
  std::shared_mutex mutex_;
  core::RecordIndex index_;  ///< by trial
  LongTurn long_search_{{0, 0}};
};

}  // namespace faultlab::server::course
