#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/storage/recording_store.h"

namespace faultlab::server {

struct DamagedRecording {
  std::string id;
  std::string what;
};

/// The recordings whose samples are not all there, or not as they were written: each chunk is read
/// and its checksum verified, and the samples are counted.
core::Result<std::vector<DamagedRecording>> FindDamagedRecordings(Database& database);

/// Whether an SQLite database has all that faultlab makes, and no trigger that it does not make or
/// that somebody has changed: such a one acts on what the server writes. What else others have
/// added is theirs. Makes a database in the folder for temporary files to compare with.
core::Status CheckSchema(Database& database);

/// The engine's own check, then the recordings. An Error says what is damaged and what to do.
core::Status CheckDatabase(Database& database);

/// Deletes the damaged chunks of a recording, so that the rest can be read, and says so in its
/// events.
/// @param gap  the event for samples that are missing from `index` on
/// @returns the number of samples that are lost
core::Result<std::int64_t> CutDamage(
    Database& database,
    const std::string& run_id,
    const std::function<RecordedEvent(std::int64_t index, std::int64_t samples)>& gap);

}  // namespace faultlab::server
