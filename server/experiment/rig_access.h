#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types/result.h"
#include "server/auth/principal.h"
#include "server/clock.h"
#include "server/experiment/benches.h"
#include "server/experiment/waiting_line.h"
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
  /// All must outlive it.
  RigAccess(lab::LabService& service,
            RigPool& rig_pool,
            const Clock& clock,
            std::function<void(std::string_view)> log);
  ~RigAccess();
  RigAccess(const RigAccess&) = delete;
  RigAccess& operator=(const RigAccess&) = delete;

  /// For a run of at most `length` on `rig` ("": any free simulator of `bench`). kForbidden without
  /// a session, kConflict when the rig hangs on another member, kUnavailable before its first
  /// check, kBusy when the simulator is not free, and "in_line" for a person when none is. Jobs,
  /// and whoever names a simulator, take nothing that the line waits for.
  core::Result<RigHandle> Hold(const Principal& who,
                               StartedBy by,
                               const std::string& rig,
                               const core::Bench& bench,
                               std::chrono::milliseconds length);
  /// The same refusal "in_line", before anything is prepared for the run of a person: whoever asks
  /// again in time keeps the place. Once it is their turn, what comes of it ends with LeaveLine,
  /// unless it is "in_line" again.
  core::Status AwaitTurn(const Principal& who,
                         const core::Bench& bench,
                         std::chrono::milliseconds length);
  void LeaveLine(const Principal& who, const core::Bench& bench);
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
  std::vector<lab::RigId> SimulatorsOf(const core::Bench& bench) const;
  /// kBusy "in_line" unless as many of these are free as stand before this caller, and one more.
  core::Status CheckTurn(const Principal& who,
                         const std::string& bench,
                         const std::vector<lab::RigId>& simulators,
                         std::chrono::milliseconds length,
                         const lab::LabState& state,
                         WallTime now);
  std::optional<core::Error> RefusalOfStranger(const std::string& rig) const;
  void EndPractice(const lab::Lease& lease);

  lab::LabService& service_;
  RigPool& rig_pool_;
  const Clock& clock_;
  WaitingLine line_;
  const std::function<void(std::string_view)> log_;
};

}  // namespace faultlab::server
