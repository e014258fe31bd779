#pragma once

#include <sys/types.h>

#include <string>

namespace faultlab::tests {

/// A private PostgreSQL cluster in a temporary folder, reachable by a unix socket only. The first
/// test that needs it starts it; it ends with the process (also when that is killed). Needs no
/// rights: as root it runs as `postgres` or `nobody`, because initdb refuses root.
class PostgresCluster {
 public:
  /// The cluster of this process; throws std::runtime_error when PostgreSQL cannot start.
  static PostgresCluster& Instance();

  /// A new, empty database; the connection string for DatabaseOptions::location.
  std::string CreateDatabase();
  /// Ends every connection to all databases, as a restart of the server would.
  void KillConnections();

  PostgresCluster(const PostgresCluster&) = delete;
  PostgresCluster& operator=(const PostgresCluster&) = delete;

 private:
  PostgresCluster();
  ~PostgresCluster();
  void Execute(const std::string& statement) const;

  std::string folder_;
  pid_t server_ = -1;
  int databases_ = 0;
};

}  // namespace faultlab::tests
