#pragma once

#include <optional>
#include <string>

#include "core/types/result.h"
#include "server/lab/rig_check.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server::lab {

/// The calibrated band of each rig (rule 7 of the README), written when an operator commissions it.
/// A rig without a band is compared with the data sheet. Thread-safe, stateless.
class RigBands {
 public:
  explicit RigBands(Database& database) : database_(database) {}

  core::Result<std::optional<RigBand>> Get(const std::string& rig);
  /// `source` describes for people how the band was found.
  core::Status Put(const std::string& rig,
                   const RigBand& band,
                   const std::string& source,
                   WallTime now);
  /// The rig is another one now, under the same name.
  core::Status Forget(const std::string& rig);

 private:
  Database& database_;
};

}  // namespace faultlab::server::lab
