#include "server/storage/recording_store.h"

#include <soci/soci.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

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
using soci::into;
using soci::use;

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

/// Reads the row for an update; on PostgreSQL other writers of this run wait until the commit.
std::optional<Progress> LockRun(Transaction& tx, const std::string& run_id) {
  Progress progress;
  std::string query = "SELECT state, samples, next_index, kept_run FROM recording WHERE id = :id";
  if (tx.engine() == Engine::kPostgresql) query += " FOR UPDATE";
  tx.sql() << query, into(progress.state), into(progress.samples), into(progress.next_index),
      into(progress.kept_run), use(run_id, "id");
  if (!tx.sql().got_data()) return std::nullopt;
  return progress;
}

std::int64_t NextEvent(Transaction& tx, const std::string& run_id) {
  std::int64_t seq = 0;
  tx.sql() << "SELECT COALESCE(MAX(seq), -1) + 1 FROM recording_event WHERE recording_id = :id",
      into(seq), use(run_id, "id");
  return seq;
}

void AddEvents(Transaction& tx,
               const std::string& run_id,
               std::span<const RecordedEvent> events,
               std::int64_t seq) {
  for (const auto& event : events) {
    tx.sql() << "INSERT INTO recording_event (recording_id, seq, sample_index, kind, json) "
                "VALUES (:id, :seq, :index, :kind, :json)",
        use(run_id, "id"), use(seq, "seq"), use(event.index, "index"), use(event.kind, "kind"),
        use(event.json, "json");
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
  const std::int64_t count = progress.samples + static_cast<std::int64_t>(samples.size());
  const std::int64_t next = samples.back().index + 1;
  tx.sql() << "UPDATE recording SET samples = :samples, next_index = :next WHERE id = :id",
      use(count, "samples"), use(next, "next"), use(run_id, "id");
}

}  // namespace

std::string_view Name(RunState state) {
  return kRunStates[static_cast<std::size_t>(state)];
}

std::optional<RunState> ParseRunState(std::string_view name) {
  const auto* found = std::find(kRunStates.begin(), kRunStates.end(), name);
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
    const std::string name(Name(state));
    const std::int64_t ended_ms = ToMilliseconds(ended_at);
    tx.sql() << "UPDATE recording SET state = :state, ended_ms = :ended, diagnosis_json = :json, "
                "verdict = :verdict WHERE id = :id",
        use(name, "state"), use(ended_ms, "ended"), use(diagnosis_json, "json"),
        use(verdict, "verdict"), use(run_id, "id");
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
    const std::string name(Name(state));
    tx.sql() << "UPDATE recording SET state = :state, kept_run = '', diagnosis_json = '', "
                "verdict = '' WHERE id = :id",
        use(name, "state"), use(run_id, "id");
    return Done{};
  });
}

core::Status RecordingStore::AppendLate(const std::string& run_id,
                                        std::span<const core::Sample> samples) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    const auto progress = LockRun(tx, run_id);
    if (!progress) return NotYours();
    const auto first = std::find_if(samples.begin(), samples.end(), [&](const core::Sample& each) {
      return each.index >= progress->next_index;
    });
    const std::span<const core::Sample> missing(first, samples.end());
    if (missing.empty()) return Done{};
    CheckOrder(missing.front().index, missing);
    PutChunk(tx, run_id, *progress, missing, EncodeChunk(missing));
    tx.sql() << "UPDATE recording SET diagnosis_json = '', verdict = '' WHERE id = :id",
        use(run_id, "id");
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
    const std::string name(Name(end->state));
    const std::int64_t ended_ms = ToMilliseconds(end->at);
    tx.sql() << "UPDATE recording SET state = :state, ended_ms = :ended WHERE id = :id",
        use(name, "state"), use(ended_ms, "ended"), use(run_id, "id");
    return Done{};
  });
}

core::Status RecordingStore::ReplaceOptions(const std::string& run_id,
                                            const std::string& options_json) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!LockRun(tx, run_id)) return NotYours();
    tx.sql() << "UPDATE recording SET options_json = :options WHERE id = :id",
        use(options_json, "options"), use(run_id, "id");
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
    tx.sql() << "UPDATE recording SET plan_json = :plan, options_json = :options, "
                "diagnosis_json = '', verdict = '' WHERE id = :id",
        use(plan_json, "plan"), use(options_json, "options"), use(run_id, "id");
    tx.sql() << "DELETE FROM recording_event WHERE recording_id = :id", use(run_id, "id");
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
    tx.sql() << "UPDATE recording SET diagnosis_json = :json, verdict = :verdict WHERE id = :id",
        use(diagnosis_json, "json"), use(verdict, "verdict"), use(run_id, "id");
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
    tx.sql() << "DELETE FROM recording WHERE id = :id", use(run_id, "id");
    return Done{};
  });
}

core::Status RecordingStore::Describe(const std::string& run_id,
                                      const std::optional<std::string>& name,
                                      const std::optional<std::string>& note) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!LockRun(tx, run_id)) return NotYours();
    if (name) {
      tx.sql() << "UPDATE recording SET name = :name WHERE id = :id", use(*name, "name"),
          use(run_id, "id");
    }
    if (note) {
      tx.sql() << "UPDATE recording SET note = :note WHERE id = :id", use(*note, "note"),
          use(run_id, "id");
    }
    return Done{};
  });
}

core::Status RecordingStore::SetStar(const std::string& run_id,
                                     const std::string& who,
                                     bool starred) {
  return database_.Write(Durability::kPromise, [&](Transaction& tx) -> core::Status {
    if (!LockRun(tx, run_id)) return NotYours();
    tx.sql() << "DELETE FROM recording_star WHERE recording_id = :id AND who = :who",
        use(run_id, "id"), use(who, "who");
    if (starred) {
      tx.sql() << "INSERT INTO recording_star (recording_id, who) VALUES (:id, :who)",
          use(run_id, "id"), use(who, "who");
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
    const soci::rowset<std::string> rows =
        (tx.sql().prepare << "SELECT id FROM recording WHERE state = 'running' AND "
                             "server_id = :server AND source "
                          << source << " 'upload'",
         use(server_id, "server"));
    return std::vector<std::string>(rows.begin(), rows.end());
  };
  for (const std::string& id : running("=")) {
    EraseRecordingBlobs(tx, id);
    tx.sql() << "DELETE FROM recording WHERE id = :id", use(id, "id");
  }
  std::vector<std::string> ids = running("<>");
  const std::int64_t now_ms = ToMilliseconds(now);
  tx.sql() << "UPDATE recording SET state = 'interrupted', ended_ms = :now "
              "WHERE state = 'running' AND server_id = :server",
      use(now_ms, "now"), use(server_id, "server");
  return ids;
}

void InterruptRun(Transaction& tx, const std::string& run_id, WallTime now) {
  const std::int64_t now_ms = ToMilliseconds(now);
  tx.sql() << "UPDATE recording SET state = 'interrupted', ended_ms = :now "
              "WHERE state = 'running' AND id = :id",
      use(now_ms, "now"), use(run_id, "id");
}

}  // namespace faultlab::server
