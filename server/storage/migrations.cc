#include "server/storage/migrations.h"

#include <soci/soci.h>

#include <string_view>

#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

/// Any constant: servers that start together on one PostgreSQL migrate one after the other.
constexpr const char* kMigrationLock = "SELECT pg_advisory_xact_lock(7170281)";

std::string ForEngine(std::string statement, Engine engine) {
  const bool sqlite = engine == Engine::kSqlite;
  const auto replace = [&](std::string_view word, std::string_view by) {
    for (std::size_t at = statement.find(word); at != std::string::npos;
         at = statement.find(word, at + by.size())) {
      statement.replace(at, word.size(), by);
    }
  };
  replace("$ID", sqlite ? "INTEGER PRIMARY KEY AUTOINCREMENT" : "BIGSERIAL PRIMARY KEY");
  replace("$BLOB", sqlite ? "BLOB" : "BYTEA");
  return statement;
}

int CurrentVersion(Transaction& tx) {
  int version = 0;
  soci::indicator indicator = soci::i_null;
  tx.sql() << "SELECT MAX(version) FROM schema_version", soci::into(version, indicator);
  return indicator == soci::i_ok ? version : 0;
}

void Apply(Transaction& tx, const Migration& step) {
  for (const Statement& each : step.statements) {
    if (each.engine.value_or(tx.engine()) != tx.engine()) continue;
    Execute(tx, ForEngine(each.text, tx.engine()));
  }
  InsertInto(tx, "schema_version", {{"version", step.version}, {"description", step.description}});
}

}  // namespace

core::Status CheckOrigin(soci::session& session, Engine engine, bool existing) {
  const core::Error foreign{
      core::ErrorCode::kInvalid,
      "this is a database of another program, or of faultlab before 1.0.0; it "
      "was not changed",
      "data"};
  const bool sqlite = engine == Engine::kSqlite;
  Transaction tx(session, engine, /*writes=*/false, Durability::kTelemetry);
  int tables = 0, steps = 0, columns = 0;
  const std::string list =
      sqlite ? "SELECT COUNT(*) FROM sqlite_master WHERE type = 'table'"
             : "SELECT COUNT(*) FROM pg_tables WHERE schemaname = current_schema()";
  const std::string name = sqlite ? " AND name = " : " AND tablename = ";
  session << list, soci::into(tables);
  session << list + name + "'schema_version'", soci::into(steps);
  if (steps == 0) {
    // On PostgreSQL a schema may be shared with others.
    if (tables > 0 && (sqlite || existing)) return foreign;
    if (!existing) return core::Done{};
    return core::Error{
        core::ErrorCode::kInvalid, "the database is empty: nothing is there", "data"};
  }
  session << (sqlite ? "SELECT COUNT(*) FROM pragma_table_info('schema_version') "
                       "WHERE name IN ('version', 'description')"
                     : "SELECT COUNT(*) FROM information_schema.columns WHERE table_schema = "
                       "current_schema() AND table_name = 'schema_version' AND column_name IN "
                       "('version', 'description')"),
      soci::into(columns);
  if (columns != 2) return foreign;
  const Migration& ours = AllMigrations().front();
  session << "SELECT COUNT(*) FROM schema_version", soci::into(tables);
  session << "SELECT COUNT(*) FROM schema_version WHERE version = :v AND description = :d",
      soci::into(steps), soci::use(ours.version, "v"), soci::use(ours.description, "d");
  const bool began = tables > 0;  // otherwise its first start was cut off
  if (began && steps != 1) return foreign;
  return core::Done{};
}

core::Result<int> Migrate(soci::session& session, Engine engine, int target) {
  const int newest = AllMigrations().back().version;
  int version = 0;
  do {
    Transaction tx(session, engine, /*writes=*/true, Durability::kPromise);
    if (engine == Engine::kPostgresql) session << kMigrationLock;
    session << "CREATE TABLE IF NOT EXISTS schema_version ("
               "version INTEGER PRIMARY KEY, description TEXT NOT NULL)";
    version = CurrentVersion(tx);
    if (version > newest) {
      return core::Error{core::ErrorCode::kUnavailable,
                         "the database has schema " + std::to_string(version) +
                             ", this program knows up to " + std::to_string(newest) +
                             "; start a newer faultlab",
                         ""};
    }
    for (const auto& step : AllMigrations()) {
      if (step.version > version && step.version <= target) {
        Apply(tx, step);
        version = step.version;
        break;
      }
    }
    tx.Commit();
  } while (version < target);
  return version;
}

}  // namespace faultlab::server
