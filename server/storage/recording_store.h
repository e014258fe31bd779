#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "core/types/sample.h"
#include "server/storage/database.h"
#include "server/storage/ids.h"
#include "server/wall_time.h"

namespace faultlab::server {

enum class RunState { kRunning, kFinished, kStopped, kFailed, kInterrupted };
/// "running", "finished", "stopped", "failed", "interrupted".
std::string_view Name(RunState state);
std::optional<RunState> ParseRunState(std::string_view name);

/// Above the index of every sample.
inline constexpr std::int64_t kSampleIndexMax = 1'000'000'000;

/// What is known of one recording without its samples.
struct RunRecord {
  std::string id;         ///< set by the caller: NewId("run"), unique
  std::string name;       ///< free text, any script
  std::string owner;      ///< Principal::owner_key(): "guest", "user:7", "key:3"
  std::string rig;        ///< rig id; empty for an upload
  std::string source;     ///< "run" or "upload"
  std::string server_id;  ///< which server writes it; see InterruptRuns
  std::uint64_t epoch = 0;
  double period_s = 0.01;
  std::string plan_json = "{}";
  std::string options_json;  ///< of its diagnosis; empty in recordings of older programs
  RunState state = RunState::kRunning;
  WallTime created_at{};
  std::optional<WallTime> ended_at;
  std::int64_t samples = 0;    ///< how many are stored
  std::string diagnosis_json;  ///< empty until Finish
  std::string verdict;         ///< Name(VerdictKind), empty until Finish
};

/// One line of a run's event list, in the JSON that viewers get.
struct RecordedEvent {
  std::int64_t index = 0;  ///< the sample on which it acted
  std::string kind;        ///< "fault_commanded", "detected", ..
  std::string json;        ///< the whole event object
};

struct RunFilter {
  std::optional<std::string> owner;      ///< only this owner's
  std::optional<std::string> source;     ///< "run" or "upload"
  std::optional<std::int64_t> course{};  ///< only of those who attend it
};

struct RunPage {
  std::vector<RunRecord> items;  ///< newest first
  std::string next_cursor;       ///< empty on the last page
};

/// Recordings: run record, samples in chunks, events, final diagnosis. Thread-safe, stateless:
/// every call is one transaction. Nothing is dropped silently: a failed append answers with an
/// Error and the caller ends the run.
class RecordingStore {
 public:
  explicit RecordingStore(Database& database) : database_(database) {}

  /// Refuses an id that exists (kConflict).
  core::Status Begin(const RunRecord& record);
  /// The run that is recorded of this rig now; any, when a simulator has several.
  core::Result<std::optional<std::string>> RunningOn(const std::string& rig);
  /// Appends samples whose index begins at `first_index` (= samples.front().index) and rises.
  /// A gap to the chunk before is allowed, an overlap is refused (kConflict). Empty: nothing
  /// happens, and so does the very chunk that is stored already: a lost answer may be asked for
  /// again. Refuses a run that has ended (kConflict) or does not exist (kNotFound).
  core::Status AppendChunk(const std::string& run_id,
                           std::int64_t first_index,
                           std::span<const core::Sample> samples);
  /// @param first  how many events of the run were appended before, for who tries again after a
  /// lost answer; -1: appends them whatever is there
  core::Status AppendEvents(const std::string& run_id,
                            std::span<const RecordedEvent> events,
                            std::int64_t first = -1);
  /// Ends a running run once; a second Finish is refused (kConflict).
  core::Status Finish(const std::string& run_id,
                      RunState state,
                      WallTime ended_at,
                      const std::string& diagnosis_json,
                      const std::string& verdict);
  /// Puts a newer diagnosis beside an ended run.
  core::Status ReplaceDiagnosis(const std::string& run_id,
                                const std::string& diagnosis_json,
                                const std::string& verdict);
  /// Record, samples and events. Refuses a running run (kConflict).
  core::Status Delete(const std::string& run_id);

  /// What a recording takes even when it is shorter: 4.5 kB of rows.
  static constexpr std::int64_t kSamplesLeast = 150;
  /// How many samples the recordings of an owner hold together, each at least kSamplesLeast.
  core::Result<std::int64_t> SamplesOf(const std::string& owner);
  /// Of an owner, the recording that has ended and was made first.
  core::Result<std::optional<std::string>> OldestEndedOf(const std::string& owner);

  core::Result<RunRecord> Get(const std::string& run_id);
  /// Page by the cursor of the page before; "" starts. 1 <= limit <= 500. A cursor that this
  /// function did not make is refused (kInvalid, field "cursor").
  core::Result<RunPage> List(const std::string& cursor, int limit, const RunFilter& filter);
  /// Samples with index in [from, to), in order. Damage in a chunk is an Error, never a short
  /// answer.
  core::Result<std::vector<core::Sample>> LoadSamples(const std::string& run_id,
                                                      std::int64_t from = 0,
                                                      std::int64_t to = kSampleIndexMax);
  core::Result<std::vector<RecordedEvent>> LoadEvents(const std::string& run_id);

 private:
  Database& database_;
};

/// Ends the runs of a server that is gone, in the caller's transaction: they become `interrupted`,
/// their chunks stay, nothing can be added any more. Throws what the database throws.
/// @returns their ids.
std::vector<std::string> InterruptRuns(Transaction& tx, const std::string& server_id, WallTime now);
/// The same for one run; nothing when it has ended.
void InterruptRun(Transaction& tx, const std::string& run_id, WallTime now);

}  // namespace faultlab::server
