#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
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

/// Larger than the index of every sample.
inline constexpr std::int64_t kSampleIndexMax = 1'000'000'000;

/// Everything about one recording except its samples.
struct RunRecord {
  std::string id;         ///< set by the caller: NewId("run"), unique
  std::string name;       ///< free text, any script
  std::string owner;      ///< Principal::owner_key(): "guest", "user:7", "key:3"
  std::string rig;        ///< rig id; empty for an upload
  std::string source;     ///< "run" or "upload"
  std::string server_id;  ///< the server that writes it; see InterruptRuns
  std::uint64_t epoch = 0;
  std::string bench;  ///< core::Bench::id; empty in recordings of older programs
  double period_s = 0.01;
  std::string plan_json = "{}";
  std::string options_json;  ///< of its diagnosis; empty in recordings made by older programs
  RunState state = RunState::kRunning;
  WallTime created_at{};
  std::optional<WallTime> ended_at;
  std::int64_t samples = 0;    ///< number of stored samples
  std::string diagnosis_json;  ///< empty until Finish
  std::string verdict;         ///< Name(VerdictKind), empty until Finish
  /// hardware::Rig::kept_run, by which the rig may still have what is missing here; empty: it has
  /// nothing, or nobody asks any more.
  std::string kept_run;
  std::string note;  ///< free text of its owner

  /// Its server died, and its rest has not been read from the rig yet: see
  /// RecordingStore::AppendRecovered.
  bool AwaitsRecovery() const { return state == RunState::kInterrupted && !kept_run.empty(); }
};

/// One line of a run's event list, in the JSON that viewers get.
struct RecordedEvent {
  std::int64_t index = 0;  ///< the sample at which it acted
  std::string kind;        ///< "fault_commanded", "detected", ..
  std::string json;        ///< the whole event object
};

/// How and when a run ended.
struct RunEnd {
  RunState state = RunState::kFailed;
  WallTime at{};
};

struct RunFilter {
  std::optional<std::string> owner;      ///< only recordings of this owner
  std::optional<std::string> source;     ///< "run" or "upload"
  std::optional<std::int64_t> course{};  ///< only recordings of students of this course
  std::optional<std::string> text{};     ///< only those whose name, note or id contains this
  std::optional<std::string> rig{};
  /// Name(VerdictKind); "fault" also where all were set back before the end.
  std::optional<std::string> verdict{};
  std::optional<std::string> starred_by{};  ///< only those with a star of this Principal::owner_key
};

struct RunPage {
  std::vector<RunRecord> items;  ///< newest first
  std::string next_cursor;       ///< empty on the last page
};

/// Recordings: run record, samples in chunks, events, final diagnosis. Thread-safe, stateless:
/// every call is one transaction. Nothing is dropped silently: a failed append returns an Error,
/// and the caller ends the run.
class RecordingStore {
 public:
  explicit RecordingStore(Database& database) : database_(database) {}

  /// Refuses an id that exists (kConflict).
  core::Status Begin(const RunRecord& record);
  /// The run that is being recorded on this rig now; any one of them if a simulator has several.
  core::Result<std::optional<std::string>> RunningOn(const std::string& rig);
  /// The newest run of this owner on this rig that began in [from, to].
  core::Result<std::optional<std::string>> NewestOf(const std::string& owner,
                                                    const std::string& rig,
                                                    WallTime from,
                                                    WallTime to);
  /// Appends samples whose index begins at `first_index` (= samples.front().index) and increases. A
  /// gap to the previous chunk is allowed, an overlap is refused (kConflict). An empty chunk has no
  /// effect, nor has exactly the chunk that is already stored, so that a caller may repeat a call
  /// whose answer was lost. Refuses a run that has ended (kConflict) or does not exist (kNotFound).
  core::Status AppendChunk(const std::string& run_id,
                           std::int64_t first_index,
                           std::span<const core::Sample> samples);
  /// @param first  number of events of the run appended before, for a caller that repeats a call
  ///    whose answer was lost; -1: appends in any case
  core::Status AppendEvents(const std::string& run_id,
                            std::span<const RecordedEvent> events,
                            std::int64_t first = -1);
  /// Ends a running run once; a second Finish is refused (kConflict).
  core::Status Finish(const std::string& run_id,
                      RunState state,
                      WallTime ended_at,
                      const std::string& diagnosis_json,
                      const std::string& verdict);
  /// The options of a diagnosis that has begun anew within the run.
  core::Status ReplaceOptions(const std::string& run_id, const std::string& options_json);
  /// Stores a newer diagnosis for an ended run.
  core::Status ReplaceDiagnosis(const std::string& run_id,
                                const std::string& diagnosis_json,
                                const std::string& verdict);
  /// Opens a sealed recording: plan, options and events are replaced, its diagnosis is forgotten.
  /// Refuses a running run (kConflict).
  core::Status Unseal(const std::string& run_id,
                      const std::string& plan_json,
                      const std::string& options_json,
                      std::span<const RecordedEvent> events);
  /// Interrupted runs whose rest may still be in their rigs. Until EndRecovery they are not
  /// deleted.
  core::Result<std::vector<RunRecord>> AwaitingRecovery();
  /// Appends to such a run, as AppendChunk does to a running one. Refuses every other (kConflict).
  core::Status AppendRecovered(const std::string& run_id, std::span<const core::Sample> samples);
  /// Nothing more will come. `state` is the end as the rig knows it, kInterrupted if it does not. A
  /// diagnosis of the part that was there before is forgotten. No effect on a run that awaits
  /// nothing.
  core::Status EndRecovery(const std::string& run_id,
                           RunState state,
                           std::span<const RecordedEvent> events);

  /// Appends what a former process recorded and could not store. Samples that are there already are
  /// left out, so that a caller may begin anew. A diagnosis of the part before is forgotten.
  core::Status AppendLate(const std::string& run_id, std::span<const core::Sample> samples);
  /// Nothing more will come. If `end` is known, an interrupted run has ended like that.
  core::Status EndLate(const std::string& run_id, const std::optional<RunEnd>& end);

  /// Deletes record, samples, pictures and events. Refuses a running run, and one whose rest is
  /// being read (kConflict).
  core::Status Delete(const std::string& run_id);

  /// Samples that a shorter recording counts for: 4.5 kB of rows.
  static constexpr std::int64_t kSamplesLeast = 150;
  /// Bytes of a stored sample, for counting pictures as samples.
  static constexpr std::int64_t kSampleBytes = 30;
  /// Number of samples in all recordings of an owner, each counted as at least kSamplesLeast, and
  /// the pictures of these recordings as so many samples as need the same space.
  core::Result<std::int64_t> SamplesOf(const std::string& owner);
  /// The oldest ended recording of an owner.
  core::Result<std::optional<std::string>> OldestEndedOf(const std::string& owner);

  /// What is absent stays as it is.
  core::Status Describe(const std::string& run_id,
                        const std::optional<std::string>& name,
                        const std::optional<std::string>& note);
  /// A star is a person's own, on whatever recording.
  core::Status SetStar(const std::string& run_id, const std::string& who, bool starred);
  /// Those of `run_ids` with a star of this person.
  core::Result<std::set<std::string>> StarredOf(const std::string& who,
                                                std::span<const std::string> run_ids);
  /// The newest events of these kinds, in order, at most `most` of each run.
  core::Result<std::map<std::string, std::vector<RecordedEvent>>> EventsOf(
      std::span<const std::string> run_ids, std::span<const std::string_view> kinds, int most);

  core::Result<RunRecord> Get(const std::string& run_id);
  /// A page by the cursor of the previous page; "" is the first page. 1 <= limit <= 500. A cursor
  /// that this function did not make is refused (kInvalid, field "cursor").
  core::Result<RunPage> List(const std::string& cursor, int limit, const RunFilter& filter);
  /// Samples with index in [from, to), in order. Damage in a chunk gives an Error, never a shorter
  /// answer.
  core::Result<std::vector<core::Sample>> LoadSamples(const std::string& run_id,
                                                      std::int64_t from = 0,
                                                      std::int64_t to = kSampleIndexMax);
  core::Result<std::vector<RecordedEvent>> LoadEvents(const std::string& run_id);

 private:
  core::Status Append(const std::string& run_id,
                      RunState state,
                      std::span<const core::Sample> samples);

  Database& database_;
};

/// The owner of a recording's chunks in the blob_store; the sequence is the index of the first
/// sample.
std::string RecordingBlobs(const std::string& run_id);
/// Appends an event in the caller's transaction.
void AddRecordingEvent(Transaction& tx, const std::string& run_id, const RecordedEvent& event);
/// Ends the runs of a server that is gone, in the caller's transaction: they become `interrupted`,
/// their chunks stay, and nothing can be added any more. Half an upload is of no use to anybody and
/// goes. Throws what the database throws.
/// @returns the ids of the runs
std::vector<std::string> InterruptRuns(Transaction& tx, const std::string& server_id, WallTime now);
/// The same for one run; no effect when it has ended.
void InterruptRun(Transaction& tx, const std::string& run_id, WallTime now);

}  // namespace faultlab::server
