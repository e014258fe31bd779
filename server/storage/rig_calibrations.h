#pragma once

#include <string>
#include <vector>

#include "core/types/result.h"
#include "server/storage/database.h"
#include "server/wall_time.h"

namespace faultlab::server {

/// How the input moved while a rig was learnt: lowest, highest, rms about its mean; volts.
struct InputRange {
  double low_v = 0.0;
  double high_v = 0.0;
  double rms_v = 0.0;
};

/// The calibration of a rig from one run.
struct RigCalibration {
  std::string rig;
  std::string run;    ///< the run that was calibrated on
  std::string bench;  ///< core::Bench::id
  WallTime at{};
  std::string json;  ///< ToJson(core::Calibration)
  InputRange input{};
  std::string unfit{};  ///< why no later run may start with it; empty: it may
  std::string owner{};  ///< of the run, when it is read; empty: the run is gone
};

/// The calibrations of each rig with their dates, which show how its parameters, its delay and its
/// noise drift over months. Thread-safe, stateless.
class RigCalibrations {
 public:
  /// Number kept for each rig; older ones are deleted.
  static constexpr int kKept = 100;

  explicit RigCalibrations(Database& database) : database_(database) {}

  core::Status Add(const RigCalibration& calibration);
  /// Of the rig while it was this bench, newest first, at most `limit`. Empty for a rig that nobody
  /// knows.
  core::Result<std::vector<RigCalibration>> List(const std::string& rig,
                                                 const std::string& bench,
                                                 int limit);

 private:
  Database& database_;
};

}  // namespace faultlab::server
