#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// How often each relay of a rig has closed, as this lab has seen it: changes that the rig
/// confirmed, the return to the nominal positions, and self-tests. What somebody switched without
/// the lab is not in it. Thread-safe, stateless.
class RelayWear {
 public:
  /// A relay this near to its rated life is to be replaced.
  static constexpr double kWarnShare = 0.8;
  using Closings = std::map<int, std::int64_t>;  ///< by line: 17 is Do17

  struct Count {
    std::int64_t cycles = 0;
    WallTime since{};  ///< of the first one, or of the replacement
  };

  explicit RelayWear(Database& database) : database_(database) {}

  core::Status Add(const std::string& rig, const Closings& closings, WallTime now);
  core::Result<std::map<int, Count>> Get(const std::string& rig);
  /// The relay on this line is a new one.
  core::Status Replaced(const std::string& rig, int line, WallTime now);

 private:
  Database& database_;
};

}  // namespace faultlab::server::lab
