#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/types/result.h"

namespace soci {
class session;
}

namespace faultlab::server {

enum class Engine { kSqlite, kPostgresql };

/// What a commit guarantees.
enum class Durability {
  kPromise,    ///< on the disk before the call returns: bookings, sessions, finished runs
  kTelemetry,  ///< on SQLite a power cut may lose the last moments, but not the order: live samples
};

/// Which side of the commit an observer of a write is called at.
enum class CommitMoment { kBefore, kAfter };

struct DatabaseOptions {
  /// A file path (SQLite), or a PostgreSQL connection string: "postgresql://user@host/name" or
  /// "postgresql:host=/run/pg dbname=lab".
  std::string location;
  /// How long a caller waits for the writing connection or a free connection before kBusy.
  std::chrono::milliseconds patience{5000};
  /// SQLite: do not grow beyond this; 0 = no limit. A full quota gives the same error as a full
  /// disk.
  std::int64_t bytes_max = 0;
  int connections_max = 6;
  /// A database that faultlab has made is there already: nothing else is accepted, not even an
  /// empty one.
  bool existing = false;
  /// Receives the engine's own message of a failure, which is not shown to people. Any thread.
  std::function<void(std::string_view)> on_error{};
  /// Called before and after the commit of each write, on its thread, if set: the crash tests kill
  /// the process there.
  std::function<void(CommitMoment)> at_commit{};
};

/// One open transaction on one connection. Ends with Commit(); otherwise it is rolled back. SQLite:
/// writers start with BEGIN IMMEDIATE, so a body never has to wait half-way.
class Transaction {
 public:
  Transaction(soci::session& session, Engine engine, bool writes, Durability durability);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  /// For rows.h, which has the statements.
  soci::session& sql() { return session_; }
  Engine engine() const { return engine_; }
  void Commit();

 private:
  soci::session& session_;
  Engine engine_;
  bool open_ = false;
};

/// What a transaction gives whose body returns a Result, a plain value or nothing.
template <typename T>
struct OutcomeOf {
  using Type = core::Result<T>;
};
template <typename T>
struct OutcomeOf<core::Result<T>> {
  using Type = core::Result<T>;
};
template <>
struct OutcomeOf<void> {
  using Type = core::Status;
};

/// The only access to SQLite or PostgreSQL. Thread-safe. Creates and migrates the schema on
/// opening; a database of another program is refused and not changed.
///
/// A body runs inside one transaction: when it returns a value or nothing the transaction is
/// committed, when it returns an Error or throws it is rolled back. Database exceptions do not
/// leave this class: a full disk, a locked or corrupt file, and a lost server become an Error that
/// states what to do. A connection that was lost while unused is replaced; if it is lost within a
/// body, the result is an Error, and it is unknown whether the transaction was committed. A body
/// must not keep references to the transaction, nor start another one on the same Database.
class Database {
 public:
  static core::Result<std::unique_ptr<Database>> Open(DatabaseOptions options);
  ~Database();

  template <typename Body>
  using Outcome = typename OutcomeOf<std::invoke_result_t<Body, Transaction&>>::Type;

  template <typename Body>
  Outcome<Body> Write(Durability durability, Body&& body) {
    return Run(true, durability, std::forward<Body>(body));
  }
  template <typename Body>
  Outcome<Body> Read(Body&& body) {
    return Run(false, Durability::kTelemetry, std::forward<Body>(body));
  }

  Engine engine() const;
  const DatabaseOptions& options() const;
  int schema_version() const;

  /// Lets the engine check itself (SQLite: integrity_check; PostgreSQL: reads every table) and the
  /// foreign keys. An Error names the first damage.
  core::Status Check();
  /// Copies the whole database consistently into a new file (SQLite), while other callers continue.
  /// PostgreSQL is backed up by pg_dump; the Error says so.
  core::Status BackupTo(const std::string& path);

 private:
  struct Impl;
  explicit Database(std::unique_ptr<Impl> impl);
  enum class Begun { kNo, kYes };
  core::Status RunErased(bool writes,
                         Durability durability,
                         const std::function<core::Status(Transaction&)>& body);
  core::Status RunOnce(bool writes,
                       Durability durability,
                       const std::function<core::Status(Transaction&)>& body,
                       Begun& begun);

  template <typename Body>
  Outcome<Body> Run(bool writes, Durability durability, Body&& body) {
    std::optional<Outcome<Body>> outcome;
    const core::Status status =
        RunErased(writes, durability, [&](Transaction& transaction) -> core::Status {
          if constexpr (std::is_void_v<std::invoke_result_t<Body, Transaction&>>) {
            body(transaction);
            outcome.emplace(core::Done{});
          } else {
            outcome.emplace(body(transaction));
          }
          if (!outcome->ok()) return outcome->error();
          return core::Done{};
        });
    if (!status.ok()) return status.error();
    return std::move(*outcome);
  }

  std::unique_ptr<Impl> impl_;
};

}  // namespace faultlab::server
