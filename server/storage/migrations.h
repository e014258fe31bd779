#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"

namespace faultlab::server {

struct Statement {
  std::string text;                ///< $ID = auto-numbered key, $BLOB = bytes
  std::optional<Engine> engine{};  ///< of this one alone
};
/// One step of the schema, forward only. A released step never changes; a change is a new step.
struct Migration {
  int version;
  std::string description;
  std::vector<Statement> statements;
};

/// schema.sql, then what came after it.
const std::vector<Migration>& AllMigrations();

/// Refuses the database of another program; an empty one too if it must exist already. Writes
/// nothing.
core::Status CheckOrigin(soci::session& session, Engine engine, bool existing);

/// Applies the missing steps up to `target`, each in one transaction, and returns the version
/// reached. Safe when two servers start at once. Refuses a schema newer than this program.
core::Result<int> Migrate(soci::session& session, Engine engine, int target);

}  // namespace faultlab::server
