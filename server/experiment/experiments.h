#pragma once

#include "core/types/result.h"
#include "server/experiment/experiment_plan.h"
#include "server/experiment/fault_set_access.h"
#include "server/experiment/recordings.h"
#include "server/experiment/rig_access.h"
#include "server/experiment/storage_quota.h"
#include "server/run/run_manager.h"
#include "server/run/run_places.h"

namespace faultlab::server {

/// Starts what people and jobs want to run.
///
///   api, jobs --ExperimentPlan--> Experiments --> fault set, rig in hand, RunPlan --> RunManager
///
/// Thread-safe.
class Experiments {
 public:
  struct Parts {
    RunManager& runs;
    RecordingStore& store;
    Recordings& recordings;
    RigBay& bay;
    RigAccess& rigs;
    FaultSetAccess& fault_set_access;
    lab::FaultSets& fault_sets;
    RunPlaces& places;
    StorageQuota& quota;
    double speed = 1.0;  ///< of replays
  };
  /// All parts must outlive it.
  explicit Experiments(Parts parts) : parts_(parts) {}

  /// An experiment on a rig, or the replay of a recording. Refusals name the member of the plan by
  /// a JSON pointer; see RigAccess::Hold for those of the rig.
  core::Result<RunSnapshot> Start(const Principal& who, StartedBy by, ExperimentPlan plan);

  /// Refuses now what Start would refuse later, but for the state of the rig. A fault set is taken:
  /// its faults stand in the plan then.
  /// (The set is used when a run of it starts or is kept as a job: MarkUsed.)
  core::Status Check(const Principal& who, ExperimentPlan& plan);

 private:
  core::Status TakeFaultSet(const Principal& who, ExperimentPlan& plan);
  core::Result<RunRequest> OnRig(const Principal& who, StartedBy by, const ExperimentPlan& plan);
  core::Result<RunRequest> Replay(const Principal& who, StartedBy by, const ExperimentPlan& plan);
  RunKind KindOn(const std::string& rig) const;
  core::Result<std::shared_ptr<void>> PlaceFor(const Principal& who,
                                               StartedBy by,
                                               RunKind kind,
                                               std::int64_t samples);

  Parts parts_;
};

}  // namespace faultlab::server
