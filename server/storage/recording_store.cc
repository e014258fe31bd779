#include "server/storage/recording_store.h"

#include <algorithm>
#include <string_view>

#include "core/types/check.h"
#include "server/storage/blob_store.h"
#include "server/storage/chunk_codec.h"
#include "server/storage/not_yours.h"
#include "server/storage/picture_store.h"
#include "server/storage/recording_rows.h"
#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

using core::Done;
using core::Error;
using core::ErrorCode;

Error NotEnded() {
  return core::Refuse("run_not_ended");
}

struct NewRun {
  RunRecord run;
  std::int64_t next_index = 0;
};

template <typename Visit>
void Fields(NewRun& of, Visit&& visit) {
  server::Fields(of.run, visit);
  visit("next_index", of.next_index);
}

struct Progress {
  std::string state;
  std::int64_t samples = 0;
  std::int64_t next_index = 0;
  std::string kept_run;

  bool AwaitsRecovery() const { return state == Name(RunState::kInterrupted) && !kept_run.empty(); }
};

template <typename Visit>
void Fields(Progress& of, Visit&& visit) {
  visit("state", of.state);
  visit("samples", of.samples);
  visit("next_index", of.next_index);
  visit("kept_run", of.kept_run);
}

/// Reads the row for an update; on PostgreSQL other writers of this run wait until the commit.
std::optional<Progress> LockRun(Transaction& tx, const std::string& run_id) {
  const std::string lock = tx.engine() == Engine::kPostgresql ? " FOR UPDATE" : "";
  return SelectRow<Progress>(tx, "recording WHERE id = :id" + lock, {{"id", run_id}});
}

std::int64_t NextEvent(Transaction& tx, const std::string& run_id) {
  return *SelectValue<std::int64_t>(
      tx,
      "SELECT COALESCE(MAX(seq), -1) + 1 FROM recording_event WHERE recording_id = :id",
      {{"id", run_id}});
}

void AddEvents(Transaction& tx,
               const std::string& run_id,
               std::span<const RecordedEvent> events,
               std::int64_t seq) {
  for (const auto& event : events) {
    InsertInto(tx,
               "recording_event",
               {{"recording_id", run_id},
                {"seq", seq},
                {"sample_index", event.index},
                {"kind", event.kind},
                {"json", event.json}});
    ++seq;
  }
}

void CheckOrder(std::int64_t first_index, std::span<const core::Sample> samples) {
  LAB_CHECK(samples.front().index == first_index, samples.front().index, first_index);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    LAB_CHECK(samples[i].index > samples[i - 1].index, samples[i].index);
  }
}

void PutChunk(Transaction& tx,
              const std::string& run_id,
              const Progress& progress,
              std::span<const core::Sample> samples,
              const Bytes& bytes) {
  blob_store::Put(tx, RecordingBlobs(run_id), samples.front().index, bytes);
  UpdateWhere(tx,
              "recording",
              {{"samples", progress.samples + static_cast<std::int64_t>(samples.size())},
               {"next_index", samples.back().index + 1}},
              {{"id", run_id}});
}

}  // namespace

std::string_view Name(RunState state) {
  return kRunStates[static_cast<std::size_t>(state)];
}

std::optional<RunState> ParseRunState(std::string_view name) {
  const auto* found = std::ranges::find(kRunStates, name);
  if (found == kRunStates.end()) return std::nullopt;
  return static_cast<RunState>(found - kRunStates.begin());
}

core::Status RecordingStore::Begin(const RunRecord& record) {
  LAB_CHECK(!record.id.empty());
  return database_.Write(Durability::kPromise, [&](Transaction& tx) {
    InsertRow(tx, "recording", NewRun{record}, "ended_ms");
  });
}

core::Status RecordingStore::AppendChunk(const std::string& run_id,
                                         std::int64_t first_index,
                                         std::span<const core::Sample> samples) {
  if (samples.empty()) return Done{};
  CheckOrder(first_index, samples);
  return Append(run_id, RunState::kRunning, samples);
}

core::Status RecordingStore::AppendRecovered(const std::string& run_id,
                                             std::span<const core::Sample> samples) {
  if (samples.empty()) return Done{};
  CheckOrder(samples.front().index, samples);
  return Append(run_id, RunState::kInterrupted, samples);
}

core::Status RecordingStore::Append(const std::string& run_id,
                                    RunState state,
                                    std::span<const core::Sample> samples) {
  const std::int64_t first_index = samples.front().index;
  const Bytes bytes = EncodeChunk(samples);
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) -> core::Status {
    const auto progress = LockRun(tx, run_id);
    if (!progress) return NotYours();
    const bool rest = state == RunState::kInterrupted;
    if (rest ? !progress->AwaitsRecovery() : progress->state != Name(state)) {
      return core::Refuse("run_ended");
    }
    if (first_index < progress->next_index) {
      // The answer to an earlier try was lost; the chunk is already stored.
      if (blob_store::Get(tx, RecordingBlobs(run_id), first_index) == bytes) return Done{};
      return Error{ErrorCode::kConflict,
                   "samples from " + std::to_string(first_index) +
                       " overlap what is stored up to " + std::to_string(progress->next_index),
                   "",
                   "internal"};
    }
    PutChunk(tx, run_id, *progress, samples, bytes);
    return Done{};
  });
}

core::Status RecordingStore::AppendEvents(const std::string& run_id,
                                          std::span<const RecordedEvent> events,
                                          std::int64_t first) {
  if (events.empty()) return Done{};
  return database_.Write(Durability::kTelemetry, [&](Transaction& tx) -> core::Status {
    if (!LockRun(tx, run_id)) return NotYours();
    const std::int64_t seq = NextEvent(tx, run_id);
    if (first >= 0 && seq >= first + static_cast<std::int64_t>(events.size())) return Done{};
    AddEvents(tx, run_id, events, seq);
    return Done{};
  });
}

core::Status RecordingStore::Finish(const std::string& run_id,
                                    RunState state,
                                    WallTime ended_at,
                                    const std::string& diagnosis_json,
                                    const std::string& verdict) {
  LAB_CHECK(state != RunState::kRunning);
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto progress = LockRun(tx, run_id);
    if (!progress) return NotYours();
    if (progress->state != Name(RunState::kRunning)) {
      return core::Refuse("run_ended");
    }
    UpdateWhere(tx,
                "recording",
                {{"state", Name(state)},
                 {"ended_ms", ended_at},
                 {"diagnosis_json", diagnosis_json},
                 {"verdict", verdict}},
                {{"id", run_id}});
    return Done{};
  });
}

core::Status RecordingStore::EndRecovery(const std::string& run_id,
                                         RunState state,
                                         std::span<const RecordedEvent> events) {
  LAB_CHECK(state != RunState::kRunning);
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto progress = LockRun(tx, run_id);
    if (!progress) return NotYours();
    if (!progress->AwaitsRecovery()) return Done{};
    AddEvents(tx, run_id, events, NextEvent(tx, run_id));
    UpdateWhere(tx,
                "recording",
                {{"state", Name(state)}, {"kept_run", ""}, {"diagnosis_json", ""}, {"verdict", ""}},
                {{"id", run_id}});
    return Done{};
  });
}

core::Status RecordingStore::AppendLate(const std::string& run_id,
                                        std::span<const core::Sample> samples) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto progress = LockRun(tx, run_id);
    if (!progress) return NotYours();
    const auto first = std::ranges::find_if(
        samples, [&](const core::Sample& each) { return each.index >= progress->next_index; });
    const std::span<const core::Sample> missing(first, samples.end());
    if (missing.empty()) return Done{};
    CheckOrder(missing.front().index, missing);
    PutChunk(tx, run_id, *progress, missing, EncodeChunk(missing));
    UpdateWhere(tx, "recording", {{"diagnosis_json", ""}, {"verdict", ""}}, {{"id", run_id}});
    return Done{};
  });
}

core::Status RecordingStore::EndLate(const std::string& run_id, const std::optional<RunEnd>& end) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto progress = LockRun(tx, run_id);
    if (!progress) return NotYours();
    const bool open = progress->state == Name(RunState::kInterrupted) ||
                      progress->state == Name(RunState::kRunning);
    if (!end || !open) return Done{};
    UpdateWhere(
        tx, "recording", {{"state", Name(end->state)}, {"ended_ms", end->at}}, {{"id", run_id}});
    return Done{};
  });
}

core::Status RecordingStore::ReplaceOptions(const std::string& run_id,
                                            const std::string& options_json) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!LockRun(tx, run_id)) return NotYours();
    UpdateWhere(tx, "recording", {{"options_json", options_json}}, {{"id", run_id}});
    return Done{};
  });
}

core::Status RecordingStore::Unseal(const std::string& run_id,
                                    const std::string& plan_json,
                                    const std::string& options_json,
                                    std::span<const RecordedEvent> events) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto progress = LockRun(tx, run_id);
    if (!progress) return NotYours();
    if (progress->state == Name(RunState::kRunning)) return NotEnded();
    UpdateWhere(tx,
                "recording",
                {{"plan_json", plan_json},
                 {"options_json", options_json},
                 {"diagnosis_json", ""},
                 {"verdict", ""}},
                {{"id", run_id}});
    DeleteFrom(tx, "recording_event", {{"recording_id", run_id}});
    for (const RecordedEvent& event : events) AddRecordingEvent(tx, run_id, event);
    return Done{};
  });
}

core::Status RecordingStore::ReplaceDiagnosis(const std::string& run_id,
                                              const std::string& diagnosis_json,
                                              const std::string& verdict) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto progress = LockRun(tx, run_id);
    if (!progress) return NotYours();
    if (progress->state == Name(RunState::kRunning)) return NotEnded();
    UpdateWhere(tx,
                "recording",
                {{"diagnosis_json", diagnosis_json}, {"verdict", verdict}},
                {{"id", run_id}});
    return Done{};
  });
}

core::Status RecordingStore::Delete(const std::string& run_id) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto progress = LockRun(tx, run_id);
    if (!progress) return NotYours();
    if (progress->state == Name(RunState::kRunning)) {
      return core::Refuse("run_not_ended");
    }
    if (progress->AwaitsRecovery()) {
      return Error{ErrorCode::kConflict,
                   "The rest of this run is being read from its rig; delete it in a few minutes.",
                   "",
                   "rest_awaited"};
    }
    EraseRecordingBlobs(tx, run_id);
    DeleteFrom(tx, "recording", {{"id", run_id}});
    return Done{};
  });
}

core::Status RecordingStore::Describe(const std::string& run_id,
                                      const std::optional<std::string>& name,
                                      const std::optional<std::string>& note) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!LockRun(tx, run_id)) return NotYours();
    if (name) {
      UpdateWhere(tx, "recording", {{"name", *name}}, {{"id", run_id}});
    }
    if (note) {
      UpdateWhere(tx, "recording", {{"note", *note}}, {{"id", run_id}});
    }
    return Done{};
  });
}

core::Status RecordingStore::SetStar(const std::string& run_id,
                                     const std::string& who,
                                     bool starred) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!LockRun(tx, run_id)) return NotYours();
    DeleteFrom(tx, "recording_star", {{"recording_id", run_id}, {"who", who}});
    if (starred) {
      InsertInto(tx, "recording_star", {{"recording_id", run_id}, {"who", who}});
    }
    return Done{};
  });
}

std::string RecordingBlobs(const std::string& run_id) {
  return "recording:" + run_id;
}

void AddRecordingEvent(Transaction& tx, const std::string& run_id, const RecordedEvent& event) {
  AddEvents(tx, run_id, std::span(&event, 1), NextEvent(tx, run_id));
}

std::vector<std::string> InterruptRuns(Transaction& tx,
                                       const std::string& server_id,
                                       WallTime now) {
  const auto running = [&](const char* source) {
    return SelectColumn<std::string>(tx,
                                     "SELECT id FROM recording WHERE state = 'running' AND "
                                     "server_id = :server AND source " +
                                         std::string(source) + " 'upload'",
                                     {{"server", server_id}});
  };
  for (const std::string& id : running("=")) {
    EraseRecordingBlobs(tx, id);
    DeleteFrom(tx, "recording", {{"id", id}});
  }
  std::vector<std::string> ids = running("<>");
  UpdateWhere(tx,
              "recording",
              {{"state", "interrupted"}, {"ended_ms", now}},
              {{"state", "running"}, {"server_id", server_id}});
  return ids;
}

void InterruptRun(Transaction& tx, const std::string& run_id, WallTime now) {
  UpdateWhere(tx,
              "recording",
              {{"state", "interrupted"}, {"ended_ms", now}},
              {{"state", "running"}, {"id", run_id}});
}

}  // namespace faultlab::server
