#include "server/storage/database.h"

#include <soci/soci.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <utility>
#include <vector>

#include "server/storage/connection_pool.h"
#include "server/storage/database_error.h"
#include "server/storage/migrations.h"
#include "server/storage/postgres_location.h"
#include "server/storage/rows.h"

namespace faultlab::server {
namespace {

using core::Error;
using core::ErrorCode;

const char* BeginStatement(Engine engine, bool writes) {
  if (engine == Engine::kSqlite) return writes ? "BEGIN IMMEDIATE" : "BEGIN";
  return writes ? "BEGIN" : "BEGIN READ ONLY";
}

/// For failures that only a command of the operator can cause.
Error ForOperators(TranslatedError failure) {
  failure.error.message += ": " + failure.engine_says;
  return std::move(failure.error);
}

std::vector<std::string> TableNames(Transaction& tx) {
  const std::string query =
      tx.engine() == Engine::kSqlite
          ? "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite_%'"
          : "SELECT tablename FROM pg_tables WHERE schemaname = current_schema()";
  return SelectColumn<std::string>(tx, query);
}

}  // namespace

Transaction::Transaction(soci::session& session, Engine engine, bool writes, Durability durability)
    : session_(session), engine_(engine) {
  const bool promise = durability == Durability::kPromise;
  if (engine == Engine::kSqlite && writes) {
    session_ << (promise ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = NORMAL");
  }
  session_ << BeginStatement(engine, writes);
  open_ = true;
  // PostgreSQL commits both in full, because its server may crash while this one continues to
  // record.
}

Transaction::~Transaction() {
  if (!open_) return;
  try {
    session_ << "ROLLBACK";
  } catch (const std::exception&) {
    // The engine has already rolled back (full disk, lost connection); there is nothing to undo.
  }
}

void Transaction::Commit() {
  session_ << "COMMIT";
  open_ = false;
}

struct Database::Impl {
  Impl(Engine the_engine, const DatabaseOptions& the_options, DatabaseOptions of_connections)
      : engine(the_engine), options(the_options), pool(the_engine, std::move(of_connections)) {}
  const Engine engine;
  const DatabaseOptions options;
  /// Reports a repeated failure at most once a second: if the database is away, every request
  /// fails.
  void Tell(const TranslatedError& failure) {
    if (!options.on_error || failure.error.code == ErrorCode::kBusy) return;
    const auto now = std::chrono::steady_clock::now();
    {
      const std::lock_guard lock(told_mutex);
      if (told == failure.engine_says && now - told_at < std::chrono::seconds(1)) return;
      told = failure.engine_says;
      told_at = now;
    }
    options.on_error("database: " + failure.error.message + ": " + failure.engine_says);
  }

  ConnectionPool pool;
  int schema_version = 0;
  std::mutex told_mutex;
  std::string told;
  std::chrono::steady_clock::time_point told_at{};
};

Database::Database(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Database::~Database() = default;

core::Result<std::unique_ptr<Database>> Database::Open(DatabaseOptions options) {
  if (options.location.empty()) {
    return Error{ErrorCode::kInvalid, "no database given: name a file or postgresql://..", ""};
  }
  const bool postgres = IsPostgres(options.location);
  const std::size_t scheme = options.location.find("://");
  if (!postgres && scheme != std::string::npos) {
    return Error{ErrorCode::kInvalid,
                 "the database's scheme is '" +
                     options.location.substr(0, std::min<std::size_t>(scheme, 20)) +
                     "'; known are postgresql:// and the path of an SQLite file",
                 "url"};
  }
  if (!postgres && options.location.find('"') != std::string::npos) {
    return Error{ErrorCode::kInvalid, "a database path cannot hold a double quote", ""};
  }
  const Engine engine = postgres ? Engine::kPostgresql : Engine::kSqlite;
  DatabaseOptions of_connections = options;
  if (postgres) {
    TRY(of_connections.location, PostgresParameters(options.location));
  }
  auto impl = std::make_unique<Impl>(engine, options, std::move(of_connections));
  try {
    auto lease = impl->pool.Acquire(/*writes=*/true);
    TRY_DONE(CheckOrigin(lease.session(), engine, options.existing));
    TRY(impl->schema_version, Migrate(lease.session(), engine, AllMigrations().back().version));
  } catch (const std::exception& exception) {
    return ForOperators(TranslateDatabaseError(exception));
  }
  return std::unique_ptr<Database>(new Database(std::move(impl)));
}

Engine Database::engine() const {
  return impl_->engine;
}
const DatabaseOptions& Database::options() const {
  return impl_->options;
}
int Database::schema_version() const {
  return impl_->schema_version;
}

core::Status Database::RunErased(bool writes,
                                 Durability durability,
                                 const std::function<core::Status(Transaction&)>& body) {
  Begun begun = Begun::kYes;
  core::Status status = RunOnce(writes, durability, body, begun);
  if (begun == Begun::kYes) return status;
  // The server was restarted while the connections waited in the pool; nothing has been done yet.
  impl_->pool.DropIdle();
  return RunOnce(writes, durability, body, begun);
}

/// @param begun  kNo when a connection of the pool was lost before its transaction began
core::Status Database::RunOnce(bool writes,
                               Durability durability,
                               const std::function<core::Status(Transaction&)>& body,
                               Begun& begun) {
  begun = Begun::kYes;
  try {
    auto lease = impl_->pool.Acquire(writes);
    try {
      begun = Begun::kNo;
      Transaction tx(lease.session(), impl_->engine, writes, durability);
      begun = Begun::kYes;
      const core::Status status = body(tx);
      if (!status.ok()) return status;
      const bool watched = writes && impl_->options.at_commit != nullptr;
      if (watched) impl_->options.at_commit(CommitMoment::kBefore);
      tx.Commit();
      if (watched) impl_->options.at_commit(CommitMoment::kAfter);
      return status;
    } catch (const core::ContractError&) {
      throw;
    } catch (const std::exception& exception) {
      const TranslatedError translated = TranslateDatabaseError(exception);
      impl_->Tell(translated);
      if (translated.connection_lost) {
        lease.Discard();
      } else {
        begun = Begun::kYes;
      }
      return translated.error;
    }
  } catch (const core::ContractError&) {
    throw;
  } catch (const std::exception& exception) {
    const TranslatedError translated = TranslateDatabaseError(exception);
    impl_->Tell(translated);
    return translated.error;
  }
}

core::Status Database::Check() {
  return Read([](Transaction& tx) -> core::Status {
    if (tx.engine() == Engine::kPostgresql) {
      Execute(tx, "SET LOCAL statement_timeout = 0");  // this reads everything
      for (const auto& table : TableNames(tx)) {
        CountRows(tx, "(SELECT t::text FROM " + table + " t) everything");
      }
      return core::Done{};
    }
    const auto finding = SelectValue<std::string>(tx, "PRAGMA integrity_check(1)");
    if (finding != "ok") {
      return Error{ErrorCode::kUnavailable,
                   "the database is damaged: " + finding.value_or("it cannot be checked"),
                   ""};
    }
    if (const auto table =
            SelectValue<std::string>(tx, "SELECT \"table\" FROM pragma_foreign_key_check")) {
      return Error{ErrorCode::kUnavailable, "a row of " + *table + " points to nothing", ""};
    }
    return core::Done{};
  });
}

core::Status Database::BackupTo(const std::string& path) {
  if (impl_->engine == Engine::kPostgresql) {
    return Error{ErrorCode::kInvalid, "back up PostgreSQL with pg_dump -Fc; see deploy", ""};
  }
  try {
    auto lease = impl_->pool.Acquire(/*writes=*/false);
    lease.session() << "VACUUM INTO :path", soci::use(path, "path");
  } catch (const std::exception& exception) {
    return ForOperators(TranslateDatabaseError(exception));
  }
  return core::Done{};
}

}  // namespace faultlab::server
