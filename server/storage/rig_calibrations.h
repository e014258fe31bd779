#pragma once

#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// What one run taught about its rig.
struct RigCalibration {
  std::string rig;
  std::string run;  ///< the run that was calibrated on
  WallTime at{};
  std::string json;  ///< ToJson(core::Calibration)
};

/// The calibrations of each rig, dated: how its parameters, its delay and its noise drift over the
/// months. Thread-safe, stateless.
class RigCalibrations {
 public:
  /// Kept for each rig; older ones go.
  static constexpr int kKept = 100;

  explicit RigCalibrations(Database& database) : database_(database) {}

  core::Status Add(const RigCalibration& calibration);
  /// Newest first, at most `limit`. Empty for a rig that nobody knows.
  core::Result<std::vector<RigCalibration>> List(const std::string& rig, int limit);

 private:
  Database& database_;
};

}  // namespace faultlab::server
