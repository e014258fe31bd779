#include "server/storage/migrations.h"

namespace faultlab::server {
namespace {

Migration Recordings() {
  return {.version = 1,
          .description = "recordings: record, chunks, events",
          .statements =
              {"CREATE TABLE recording ("
               "id TEXT PRIMARY KEY, name TEXT NOT NULL, owner TEXT NOT NULL, rig TEXT NOT NULL, "
               "source TEXT NOT NULL, server_id TEXT NOT NULL, epoch BIGINT NOT NULL, "
               "period_s DOUBLE PRECISION NOT NULL, plan_json TEXT NOT NULL, state TEXT NOT NULL, "
               "created_ms BIGINT NOT NULL, ended_ms BIGINT, samples BIGINT NOT NULL, "
               "next_index BIGINT NOT NULL, diagnosis_json TEXT NOT NULL, verdict TEXT NOT NULL)",
               "CREATE INDEX recording_by_time ON recording (created_ms, id)",
               "CREATE INDEX recording_by_owner ON recording (owner, created_ms, id)",
               "CREATE TABLE recording_event ("
               "recording_id TEXT NOT NULL REFERENCES recording (id) ON DELETE CASCADE, "
               "seq BIGINT NOT NULL, sample_index BIGINT NOT NULL, kind TEXT NOT NULL, "
               "json TEXT NOT NULL, PRIMARY KEY (recording_id, seq))",
               "CREATE TABLE blob_store ("
               "owner TEXT NOT NULL, seq BIGINT NOT NULL, bytes $BLOB NOT NULL, "
               "PRIMARY KEY (owner, seq))"},
          .sqlite_statements = {},
          .postgres_statements = {}};
}

}  // namespace

const std::vector<Migration>& AllMigrations() {
  static const std::vector<Migration> kAll = {Recordings()};
  return kAll;
}

}  // namespace faultlab::server
