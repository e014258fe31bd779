#include "server/storage/database_check.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>

#include "server/storage/blob_store.h"
#include "server/storage/chunk_codec.h"
#include "server/storage/ids.h"
#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;

constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();

struct Chunks {
  std::int64_t samples = 0;           ///< of the chunks that can be read
  std::vector<std::int64_t> damaged;  ///< first index of each of the others
  std::string what;                   ///< of the first one
};

Chunks ReadChunks(Transaction& tx, const std::string& run_id) {
  Chunks out;
  blob_store::ForEach(
      tx, RecordingBlobs(run_id), 0, kLast, [&](std::int64_t first, const Bytes& bytes) {
        const auto chunk = DecodeChunk(bytes);
        if (chunk.ok() && chunk.value().front().index == first) {
          out.samples += static_cast<std::int64_t>(chunk.value().size());
          return true;
        }
        if (out.what.empty()) {
          out.what = chunk.ok() ? "a chunk is at the wrong place" : chunk.error().message;
        }
        out.damaged.push_back(first);
        return true;
      });
  return out;
}

/// What an SQLite database is made of, by name.
core::Result<std::map<std::string, std::string>> SchemaOf(Database& database) {
  using Schema = std::map<std::string, std::string>;
  return database.Read([](Transaction& tx) {
    Schema schema;
    for (auto& [name, sql] : SelectTuples<std::string, std::string>(
             tx,
             "SELECT type || ' ' || name, COALESCE(sql, '') FROM sqlite_master "
             "WHERE name NOT LIKE 'sqlite\\_%' ESCAPE '\\'")) {
      schema[name] = std::move(sql);
    }
    return schema;
  });
}

}  // namespace

core::Status CheckSchema(Database& database) {
  if (database.engine() != Engine::kSqlite) return core::Done{};
  std::error_code ec;
  const auto folder = std::filesystem::temp_directory_path(ec) / NewId("schema");
  std::filesystem::create_directory(folder, ec);
  core::Result<std::map<std::string, std::string>> wanted = std::map<std::string, std::string>{};
  {
    const auto fresh = Database::Open({.location = (folder / "fresh.db").string()});
    if (fresh.ok()) wanted = SchemaOf(*fresh.value());
    if (!fresh.ok()) wanted = fresh.error();
  }
  std::filesystem::remove_all(folder, ec);
  if (!wanted.ok()) return wanted.error();
  TRY(const auto has, SchemaOf(database));
  std::string differs;
  for (const auto& [name, sql] : has) {
    if (!name.starts_with("trigger ")) continue;
    const auto found = wanted.value().find(name);
    if (found == wanted.value().end()) {
      differs += ", " + name + " is not faultlab's";
    } else if (found->second != sql) {
      differs += ", " + name + " is changed";
    }
  }
  for (const auto& [name, sql] : wanted.value()) {
    if (!has.contains(name)) differs += ", " + name + " is missing";
  }
  if (differs.empty()) return core::Done{};
  return Error{
      ErrorCode::kUnavailable,
      "this database is not as faultlab makes it: " + differs.substr(2) + ". Take another backup",
      ""};
}

namespace {

/// Empty: it is whole. A run that goes on may grow while it is read.
std::string DamageOf(Transaction& tx, const std::string& run_id) {
  const auto found = SelectTuple<std::int64_t, std::string>(
      tx, "SELECT samples, state FROM recording WHERE id = :id", {{"id", run_id}});
  if (!found) return "";
  const auto& [samples, state] = *found;
  const Chunks chunks = ReadChunks(tx, run_id);
  if (!chunks.what.empty()) return chunks.what;
  const bool grows = state == Name(RunState::kRunning) && chunks.samples > samples;
  if (chunks.samples == samples || grows) return "";
  return std::to_string(chunks.samples) + " of its " + std::to_string(samples) +
         " samples are there";
}

}  // namespace

core::Result<std::vector<DamagedRecording>> FindDamagedRecordings(Database& database) {
  constexpr int kPage = 200;
  std::vector<DamagedRecording> damaged;
  std::string after;
  for (std::string before = "-"; before != after;) {
    before = after;
    // In pages: nobody waits long for what a transaction holds.
    TRY_DONE(database.Read([&](Transaction& tx) {
      for (const std::string& id : SelectColumn<std::string>(
               tx,
               "SELECT id FROM recording WHERE id > :after ORDER BY id LIMIT :page",
               {{"after", before}, {"page", kPage}})) {
        std::string what = DamageOf(tx, id);
        if (!what.empty()) damaged.push_back({id, std::move(what)});
        after = id;
      }
    }));
  }
  return damaged;
}

core::Status CheckDatabase(Database& database) {
  TRY_DONE(database.Check());
  TRY(const auto damaged, FindDamagedRecordings(database));
  if (damaged.empty()) return core::Done{};
  constexpr std::size_t kNamed = 5;
  std::string text = "damaged recordings: " + std::to_string(damaged.size());
  for (std::size_t i = 0; i < std::min(kNamed, damaged.size()); ++i) {
    text += "; " + damaged[i].id + ": " + damaged[i].what;
  }
  return Error{ErrorCode::kUnavailable,
               text +
                   ". Restore a backup, or stop the server and run `faultlab admin check "
                   "--cut-damage`, which deletes what cannot be read of them",
               ""};
}

core::Result<std::int64_t> CutDamage(
    Database& database,
    const std::string& run_id,
    const std::function<RecordedEvent(std::int64_t index, std::int64_t samples)>& gap) {
  return database.Write(Durability::kPromise, [&](Transaction& tx) -> core::Result<std::int64_t> {
    const auto samples = SelectValue<std::int64_t>(
        tx, "SELECT samples FROM recording WHERE id = :id", {{"id", run_id}});
    if (!samples) return Error{ErrorCode::kNotFound, "no such recording", ""};
    const Chunks chunks = ReadChunks(tx, run_id);
    for (const std::int64_t first : chunks.damaged) {
      DeleteFrom(tx, "blob_store", {{"owner", RecordingBlobs(run_id)}, {"seq", first}});
    }
    const std::int64_t lost = std::max<std::int64_t>(*samples - chunks.samples, 0);
    UpdateWhere(tx, "recording", {{"samples", chunks.samples}}, {{"id", run_id}});
    const std::int64_t from = chunks.damaged.empty() ? 0 : chunks.damaged.front();
    AddRecordingEvent(tx, run_id, gap(from, lost));
    return lost;
  });
}

}  // namespace faultlab::server
