#include "server/storage/connection_pool.h"

#include <soci/postgresql/soci-postgresql.h>
#include <soci/soci.h>
#include <soci/sqlite3/soci-sqlite3.h>

#include <algorithm>
#include <string>

#include "server/storage/database_error.h"

namespace faultlab::server {
namespace {

constexpr std::int64_t kPageBytes = 4096;
/// A process that stops in the middle of a write (frozen, or its machine is gone) keeps its locked
/// rows for this long; the others must get them within the lease of a member.
constexpr const char* kWriterIdleMax = "3s";
constexpr const char* kReaderIdleMax = "30s";

/// A server behind a network that swallows everything is away, too: nobody waits for minutes. What
/// the operator writes comes later and wins.
constexpr const char* kPostgresPatience =
    "connect_timeout=5 tcp_user_timeout=10000 keepalives_idle=5 keepalives_interval=2 "
    "keepalives_count=3 ";

std::string QuotedForSoci(const std::string& path) {
  return "dbname=\"" + path + "\"";
}

std::unique_ptr<soci::session> ConnectSqlite(const DatabaseOptions& options) {
  auto session =
      std::make_unique<soci::session>(*soci::factory_sqlite3(), QuotedForSoci(options.location));
  *session << "PRAGMA busy_timeout = " + std::to_string(options.patience.count());
  int foreign = 0;  // the database of another program is refused, and stays as it is
  *session << "SELECT EXISTS (SELECT 1 FROM sqlite_master WHERE type = 'table') AND NOT EXISTS "
              "(SELECT 1 FROM sqlite_master WHERE name = 'schema_version')",
      soci::into(foreign);
  std::string mode;
  if (foreign == 0) *session << "PRAGMA journal_mode = WAL", soci::into(mode);
  *session << "PRAGMA foreign_keys = ON";
  if (options.bytes_max > 0) {
    const std::int64_t pages = std::max<std::int64_t>(options.bytes_max / kPageBytes, 1);
    std::int64_t set = 0;
    *session << "PRAGMA max_page_count = " + std::to_string(pages), soci::into(set);
  }
  return session;
}

std::unique_ptr<soci::session> ConnectPostgres(const DatabaseOptions& options, bool writes) {
  auto session = std::make_unique<soci::session>(*soci::factory_postgresql(),
                                                 kPostgresPatience + options.location);
  const std::string patience = std::to_string(options.patience.count());
  *session << "SET lock_timeout = " + patience;
  *session << "SET statement_timeout = '30s'";
  *session << "SET idle_in_transaction_session_timeout = '" +
                  std::string(writes ? kWriterIdleMax : kReaderIdleMax) + "'";
  *session << "SET client_min_messages = warning";
  *session << "SET timezone = 'UTC'";
  return session;
}

}  // namespace

ConnectionPool::ConnectionPool(Engine engine, DatabaseOptions options)
    : engine_(engine), options_(std::move(options)) {
  leased_max_ = {options_.connections_max,
                 engine == Engine::kSqlite ? 1 : options_.connections_max};
}

ConnectionPool::~ConnectionPool() = default;

std::unique_ptr<soci::session> ConnectionPool::Connect(bool writes) const {
  return engine_ == Engine::kSqlite ? ConnectSqlite(options_) : ConnectPostgres(options_, writes);
}

void ConnectionPool::DropIdle() {
  std::array<std::vector<std::unique_ptr<soci::session>>, 2> dropped;  // closed after unlocking
  const std::lock_guard lock(mutex_);
  dropped.swap(idle_);
}

ConnectionPool::Lease ConnectionPool::Acquire(bool writes) {
  const std::size_t kind = writes ? 1 : 0;
  std::unique_ptr<soci::session> session;
  {
    std::unique_lock lock(mutex_);
    const std::uint64_t ticket = next_ticket_++;
    std::deque<std::uint64_t>& line = lines_[kind];
    line.push_back(ticket);
    const bool free = freed_.wait_for(lock, options_.patience, [&] {
      return line.front() == ticket && leased_[kind] < leased_max_[kind];
    });
    std::erase(line, ticket);
    if (!line.empty()) freed_.notify_all();  // another waiter is the first now
    if (!free) throw PoolTimeout("the database is busy with other requests; try again");
    ++leased_[kind];
    if (!idle_[kind].empty()) {
      session = std::move(idle_[kind].back());
      idle_[kind].pop_back();
    }
  }
  if (session == nullptr) {
    try {
      session = Connect(writes);
    } catch (...) {
      Return(static_cast<int>(kind), nullptr);
      throw;
    }
  }
  return Lease(*this, static_cast<int>(kind), std::move(session));
}

void ConnectionPool::Return(int kind, std::unique_ptr<soci::session> session) {
  const auto index = static_cast<std::size_t>(kind);
  {
    const std::lock_guard lock(mutex_);
    --leased_[index];
    if (session != nullptr) idle_[index].push_back(std::move(session));
  }
  freed_.notify_all();
}

ConnectionPool::Lease::Lease(ConnectionPool& pool, int kind, std::unique_ptr<soci::session> session)
    : pool_(pool), kind_(kind), session_(std::move(session)) {}

ConnectionPool::Lease::~Lease() {
  pool_.Return(kind_, std::move(session_));
}

void ConnectionPool::Lease::Discard() {
  session_.reset();
}

}  // namespace faultlab::server
