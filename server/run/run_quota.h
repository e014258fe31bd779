#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/run/start_rate.h"

namespace faultlab::server {

/// The kind of rig of a run. Runs that need a session (kLeased) are not counted: there is only one
/// for each rig, and a user who waited for the rig must not find the server full.
enum class RunKind { kLeased, kSimulator, kReplay };

struct RunQuotaLimits {
  int runs_max = 32;                              ///< on simulators and replays together
  int runs_per_caller_max = 8;                    ///< of one caller
  int simulators_per_caller = 2;                  ///< of one caller, so that others have some
  int simulators_of_guests = 2;                   ///< of all without an account together
  std::int64_t replayed_samples_max = 2'000'000;  ///< of all running replays; they are in memory
  double starts_burst = 60.0;                     ///< of one caller: StartRate
  double starts_per_s = 1.0;
};

/// Limits how many runs each caller may have at the same time, and how fast they may begin them.
/// Guests together have at most half of all runs and of what replays hold: accounts keep the rest.
/// Thread-safe; places may outlive this.
class RunQuota {
 public:
  explicit RunQuota(RunQuotaLimits limits)
      : limits_(limits), rate_(limits.starts_burst, limits.starts_per_s) {}

  /// Takes a place; it is given back when the last copy is destroyed. A job has no caller: "".
  /// @param samples  number of samples of a replay
  core::Result<std::shared_ptr<void>> Take(const std::string& caller,
                                           RunKind kind,
                                           std::int64_t samples,
                                           MonotonicTime now);
  const RunQuotaLimits& limits() const { return limits_; }

 private:
  struct Count {
    int runs = 0;
    int simulators = 0;
    std::int64_t replayed = 0;  ///< samples
    void Add(int sign, int simulator, std::int64_t samples) {
      runs += sign;
      simulators += sign * simulator;
      replayed += sign * samples;
    }
  };
  struct Taken {
    std::mutex mutex;
    Count all;
    Count guests;
    std::map<std::string, Count> of_caller;  ///< callers without a run are not in it
    std::int64_t replayed_samples = 0;
  };

  const RunQuotaLimits limits_;
  StartRate rate_;
  const std::shared_ptr<Taken> taken_ = std::make_shared<Taken>();
};

}  // namespace faultlab::server
