#include "tests/support/test_database.h"

#include <stdexcept>

#include "tests/support/postgres_cluster.h"

namespace faultlab::tests {

TestDatabase::TestDatabase(server::Engine engine) {
  options_.location = engine == server::Engine::kSqlite
                          ? folder_.File("lab database.db")
                          : PostgresCluster::Instance().CreateDatabase();
  Reopen();
}

void TestDatabase::Reopen() {
  database_.reset();
  database_ = OpenAnother();
}

std::unique_ptr<server::Database> TestDatabase::OpenAnother() const {
  auto opened = server::Database::Open(options_);
  if (!opened.ok()) throw std::runtime_error(opened.error().message);
  return std::move(opened).value();
}

}  // namespace faultlab::tests
