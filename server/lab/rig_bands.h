#pragma once

#include <optional>
#include <string>

#include "core/types/result.h"
#include "server/lab/rig_check.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// The calibrated band of each rig (rule 7), written when an operator commissions it. A rig without
/// one is judged by the data sheet. Thread-safe, stateless.
class RigBands {
 public:
  explicit RigBands(Database& database) : database_(database) {}

  core::Result<std::optional<RigBand>> Get(const std::string& rig);
  /// `source` says for people how the band was found.
  core::Status Put(const std::string& rig,
                   const RigBand& band,
                   const std::string& source,
                   WallTime now);

 private:
  Database& database_;
};

}  // namespace faultlab::server::lab
