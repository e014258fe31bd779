#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/storage/database.h"
#include "tests/support/test_database.h"

namespace faultlab::tests {

/// Two writers on PostgreSQL in a fixed order: the first has executed an INSERT and keeps its
/// transaction open while the second runs completely.
class InsertRace {
 public:
  /// Rows of `table` (with a column `name`) whose name begins with "first" are inserted by the
  /// first writer.
  InsertRace(TestDatabase& database, const std::string& table);

  void Run(const std::function<void()>& first, const std::function<void()>& second);

 private:
  bool FirstWaits();

  std::unique_ptr<server::Database> gate_;
  std::unique_ptr<server::Database> looker_;
};

}  // namespace faultlab::tests
