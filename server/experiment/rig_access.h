#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include "core/types/result.h"
#include "server/auth/principal.h"
#include "server/experiment/benches.h"
#include "server/lab/lab_service.h"
#include "server/run/rig_pool.h"

namespace faultlab::server {

/// Who starts a run: somebody in their own session, or the runner in the session of a job.
enum class StartedBy { kPerson, kJob };

/// Rigs that stand somewhere and serve one person at a time. Simulators are elastic: everybody
/// makes runs on them as long as one is free.
bool NeedsSession(const RigStatus& rig);
/// Some server of the lab has, or had, this rig.
bool IsKnown(const lab::LabService& service, const RigPool& rig_pool, const std::string& rig);

/// What a rig of this server or another one is built like.
core::Result<const core::Bench*> BenchOfRig(const RigPool& rig_pool,
                                            Benches& benches,
                                            const std::string& rig);

/// Gives a rig into the hands of the lease that the caller has on it, by the newest state of the
/// lab. A run on a simulator gets a practice lease of its own, which ends when it lets go.
class RigAccess {
 public:
  /// Both must outlive it.
  RigAccess(lab::LabService& service, RigPool& rig_pool, std::function<void(std::string_view)> log);
  ~RigAccess();
  RigAccess(const RigAccess&) = delete;
  RigAccess& operator=(const RigAccess&) = delete;

  /// For a run of at most `length` on `rig` ("": any free simulator of `bench`). kForbidden without
  /// a session, kConflict when the rig hangs on another member, kUnavailable before its first
  /// check, kBusy when no simulator is free.
  core::Result<RigHandle> Hold(const Principal& who,
                               StartedBy by,
                               const std::string& rig,
                               const core::Bench& bench,
                               std::chrono::milliseconds length);
  /// May this person command what runs on this rig now? A replay has the rig "".
  bool MayCommand(const Principal& who, const std::string& rig) const;
  /// Another server of the lab has this rig.
  bool IsKnownElsewhere(const std::string& rig) const;

 private:
  core::Result<lab::Lease> LeaseFor(const Principal& who,
                                    StartedBy by,
                                    const std::string& rig,
                                    const core::Bench& bench,
                                    std::chrono::milliseconds length);
  std::optional<core::Error> RefusalOfStranger(const std::string& rig) const;
  void EndPractice(const lab::Lease& lease);

  lab::LabService& service_;
  RigPool& rig_pool_;
  const std::function<void(std::string_view)> log_;
};

}  // namespace faultlab::server
