#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "server/storage/database.h"

namespace faultlab::server {

/// Connections to one database. SQLite has one writing connection, so writers in this process wait
/// for each other here instead of polling for the file lock. Lost connections are replaced at the
/// next use.
class ConnectionPool {
 public:
  ConnectionPool(Engine engine, DatabaseOptions options);
  ~ConnectionPool();

  class Lease {
   public:
    Lease(ConnectionPool& pool, int kind, std::unique_ptr<soci::session> session);
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    soci::session& session() { return *session_; }
    /// The connection is broken: do not give it back.
    void Discard();

   private:
    ConnectionPool& pool_;
    int kind_;
    std::unique_ptr<soci::session> session_;
  };

  /// Waits up to the patience of the options. Throws PoolTimeout, or what connecting throws.
  Lease Acquire(bool writes);
  /// One connection was found dead: the other unused ones are closed without being tried.
  void DropIdle();

 private:
  std::unique_ptr<soci::session> Connect(bool writes) const;
  void Return(int kind, std::unique_ptr<soci::session> session);

  const Engine engine_;
  const DatabaseOptions options_;
  std::mutex mutex_;
  std::condition_variable freed_;
  std::array<std::vector<std::unique_ptr<soci::session>>, 2> idle_;  // [0] readers, [1] writers
  std::array<std::deque<std::uint64_t>, 2> lines_;  ///< tickets of waiting callers, oldest first
  std::uint64_t next_ticket_ = 0;
  std::array<int, 2> leased_{};
  std::array<int, 2> leased_max_{};
};

}  // namespace faultlab::server
