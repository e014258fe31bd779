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
    "the disk (or the database's quota) is full; free space, nothing was changed: ";
constexpr const char* kDamaged =
    "the database is damaged; stop the server, run `faultlab admin check`, restore a backup: ";

Error Make(ErrorCode code, const std::string& sentence, const std::exception& exception) {
  return {code, sentence + exception.what(), ""};
}

core::Error Away(const char* what, const std::exception& exception) {
  core::Error error = Make(ErrorCode::kUnavailable, what, exception);
  error.reason = kDatabaseAway;
  return error;
}

TranslatedError TranslateSqlite(const soci::sqlite3_soci_error& exception) {
  switch (exception.result() & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {Make(
          ErrorCode::kBusy, "the database is locked by another program; try again: ", exception)};
    case SQLITE_FULL:
      return {Make(ErrorCode::kUnavailable, kFull, exception)};
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return {Make(ErrorCode::kUnavailable, kDamaged, exception), true};
    case SQLITE_CANTOPEN:
      return {Make(ErrorCode::kUnavailable,
                   "the database file cannot be opened; check the path and rights: ",
                   exception),
              true};
    case SQLITE_READONLY:
      return {Make(ErrorCode::kUnavailable,
                   "the database file may not be written; check its rights: ",
                   exception)};
    case SQLITE_IOERR:
      return {Make(ErrorCode::kUnavailable, "the disk does not answer: ", exception), true};
    case SQLITE_CONSTRAINT:
      return {Make(ErrorCode::kConflict, "", exception)};
    default:
      return {Make(ErrorCode::kUnavailable, "the database refused: ", exception)};
  }
}

TranslatedError TranslatePostgres(const soci::postgresql_soci_error& exception) {
  const std::string state = exception.sqlstate();
  const std::string family = state.substr(0, 2);
  if (family == "23") return {Make(ErrorCode::kConflict, "", exception)};
  if (state == "P0001") return {Make(ErrorCode::kConflict, "", exception)};
  if (family == "40" || state == "55P03" || state == "57014") {
    return {Make(ErrorCode::kBusy, "another server holds what is needed; try again: ", exception)};
  }
  if (state == "53100") return {Make(ErrorCode::kUnavailable, kFull, exception)};
  if (state == "XX001" || state == "XX002") {
    return {Make(ErrorCode::kUnavailable, kDamaged, exception), true};
  }
  const bool refused = family == "42" || family == "22";
  if (refused) return {Make(ErrorCode::kUnavailable, "the database refused: ", exception)};
  return {Away("the database server does not answer: ", exception), true};
}

}  // namespace

bool MayPass(const core::Error& error) {
  return error.code == ErrorCode::kBusy || error.reason == kDatabaseAway;
}

TranslatedError TranslateDatabaseError(const std::exception& exception) {
  if (const auto* sqlite = dynamic_cast<const soci::sqlite3_soci_error*>(&exception)) {
    return TranslateSqlite(*sqlite);
  }
  if (const auto* postgres = dynamic_cast<const soci::postgresql_soci_error*>(&exception)) {
    return TranslatePostgres(*postgres);
  }
  if (dynamic_cast<const PoolTimeout*>(&exception) != nullptr) {
    return {Make(ErrorCode::kBusy, "", exception)};
  }
  return {Away("the database does not answer: ", exception), true};
}

}  // namespace faultlab::server
