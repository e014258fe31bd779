#include "server/storage/database_error.h"

#include <soci/postgresql/soci-postgresql.h>
#include <soci/soci.h>
#include <soci/sqlite3/soci-sqlite3.h>

#include <string>

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;

constexpr const char* kFull =
    "the disk (or the database's quota) is full; free space, nothing was changed";
constexpr const char* kDamaged =
    "the database is damaged; stop the server, run `faultlab admin check`, restore a backup";
constexpr const char* kRule = "this breaks a rule of the database; reload and try again";

Error Away(const char* what) {
  return {ErrorCode::kUnavailable, what, "", std::string(kDatabaseAway)};
}

TranslatedError TranslateSqlite(const soci::sqlite3_soci_error& exception) {
  switch (exception.result() & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {{ErrorCode::kBusy,
               "the database is locked by another program; try again",
               "",
               "database_busy"}};
    case SQLITE_FULL:
      return {{ErrorCode::kUnavailable, kFull, "", "storage_full"}};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return {{ErrorCode::kUnavailable, kDamaged, "", "database_damaged"}, {}, true};
    case SQLITE_CANTOPEN:
      return {{ErrorCode::kUnavailable,
               "the database file cannot be opened; check the path and rights",
               "",
               "database_refused"},
              {},
              true};
    case SQLITE_READONLY:
      return {{ErrorCode::kUnavailable,
               "the database file may not be written; check its rights",
               "",
               "database_refused"}};
    case SQLITE_IOERR:
      return {{ErrorCode::kUnavailable, "the disk does not answer", "", "disk_refuses"}, {}, true};
    case SQLITE_CONSTRAINT:
      return {{ErrorCode::kConflict, kRule, "", "database_rule"}};
    default:
      return {{ErrorCode::kUnavailable, "the database refused", "", "database_refused"}};
  }
}

TranslatedError TranslatePostgres(const soci::postgresql_soci_error& exception) {
  const std::string state = exception.sqlstate();
  const std::string family = state.substr(0, 2);
  if (family == "23") return {{ErrorCode::kConflict, kRule, "", "database_rule"}};
  if (state == "P0001") return {{ErrorCode::kConflict, kRule, "", "database_rule"}};
  if (family == "40" || state == "55P03" || state == "57014") {
    return {
        {ErrorCode::kBusy, "another server holds what is needed; try again", "", "database_busy"}};
  }
  if (state == "53100") return {{ErrorCode::kUnavailable, kFull, "", "storage_full"}};
  if (state == "XX001" || state == "XX002") {
    return {{ErrorCode::kUnavailable, kDamaged, "", "database_damaged"}, {}, true};
  }
  const bool refused = family == "42" || family == "22";
  if (refused) return {{ErrorCode::kUnavailable, "the database refused", "", "database_refused"}};
  return {Away("the database server does not answer"), {}, true};
}

TranslatedError Translate(const std::exception& exception) {
  if (const auto* sqlite = dynamic_cast<const soci::sqlite3_soci_error*>(&exception)) {
    return TranslateSqlite(*sqlite);
  }
  if (const auto* postgres = dynamic_cast<const soci::postgresql_soci_error*>(&exception)) {
    return TranslatePostgres(*postgres);
  }
  if (dynamic_cast<const PoolTimeout*>(&exception) != nullptr) {
    return {{ErrorCode::kBusy, "the database is busy; try again", "", "database_busy"}};
  }
  return {Away("the database does not answer"), {}, true};
}

}  // namespace

bool MayPass(const core::Error& error) {
  return error.code == ErrorCode::kBusy || error.reason == kDatabaseAway;
}

TranslatedError TranslateDatabaseError(const std::exception& exception) {
  TranslatedError translated = Translate(exception);
  translated.engine_says = exception.what();
  return translated;
}

}  // namespace faultlab::server
