#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/bench/bench.h"
#include "core/types/calibration.h"
#include "core/types/fault.h"
#include "core/types/result.h"

namespace faultlab::server {

/// The alarms of the detection bank on the demonstration of a bench, at the stated rate.
struct DetectionStudy {
  double fault_at_s = 0.0;
  double watched_from_s = 0.0;  ///< after the healthy rig was learnt
  std::vector<double> false_alarms_s;
  std::optional<double> delay_s;  ///< from the change to its alarm; absent: not detected
  std::string detector;           ///< that raised it, as in core::Alarm
  /// The statistic that is nearest to its threshold, divided by it: an alarm is above 1. The
  /// largest of each block of `block_samples`, from watched_from_s on.
  std::vector<double> level;
  int block_samples = 0;
};

/// Studies of several benches. What is learnt of a healthy demonstration rig is kept, because it
/// takes longer than the rest. Thread-safe.
class DetectionStudies {
 public:
  /// @param changes  of ParseChanges
  /// @param false_alarms_per_day  stated rate of the bank
  /// Refusals are those of PlayDemonstration and core::Calibrate. Cost: some 10 ms.
  core::Result<DetectionStudy> Study(const core::Bench& bench,
                                     const std::vector<core::Fault>& changes,
                                     double false_alarms_per_day);

 private:
  core::Result<std::shared_ptr<const core::Calibration>> CalibrationOf(
      const core::Bench& bench, const std::vector<core::Sample>& samples);

  static constexpr std::size_t kKeptMax = 100;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<const core::Calibration>> learnt_;  ///< by Bench::id
};

}  // namespace faultlab::server
