#pragma once

#include <memory>
#include <string>

#include "server/storage/database.h"
#include "tests/support/temp_folder.h"

namespace faultlab::tests {

/// An empty database of either engine that lives as long as the object. The suite that uses it is
/// parameterised over server::Engine: INSTANTIATE_TEST_SUITE_P(.., kBothEngines, EngineName).
class TestDatabase {
 public:
  explicit TestDatabase(server::Engine engine);

  server::Database& operator*() { return *database_; }
  server::Database* operator->() { return database_.get(); }
  /// Closes and opens the database, as in a restart of the server.
  void Reopen();
  /// A second server on the same database.
  std::unique_ptr<server::Database> OpenAnother() const;
  const server::DatabaseOptions& options() const { return options_; }
  const TempFolder& folder() const { return folder_; }

 private:
  TempFolder folder_;
  server::DatabaseOptions options_;
  std::unique_ptr<server::Database> database_;
};

}  // namespace faultlab::tests
