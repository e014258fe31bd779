#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// The texts of benches that recordings were made with and that rigs are. Thread-safe, stateless.
class BenchStore {
 public:
  explicit BenchStore(Database& database) : database_(database) {}

  /// An id stands for one text: of one that is stored already, only the time is renewed. Benches
  /// that nothing names are kept for days after it (server/privacy/retention.h).
  core::Status Add(const std::string& id, const std::string& text, WallTime now);
  /// Empty when there is none.
  core::Result<std::string> Text(const std::string& id);

  /// What each of these rigs is, by id of a stored bench.
  /// @returns those that were another bench before
  core::Result<std::vector<std::string>> PutRigs(const std::map<std::string, std::string>& rigs);
  /// Of the bench of a rig; empty when no member has stored one.
  core::Result<std::string> TextOfRig(const std::string& rig);
  /// Of the benches of all rigs, each once, in the order of their rigs.
  core::Result<std::vector<std::string>> TextsOfRigs();

  /// Gives recordings and calibrations of programs that named no bench this one.
  core::Status NameOlderRecordings(const std::string& id);

 private:
  Database& database_;
};

}  // namespace faultlab::server
