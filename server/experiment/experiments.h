#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "core/types/result.h"
#include "server/clock.h"
#include "server/experiment/benches.h"
#include "server/experiment/experiment_plan.h"
#include "server/experiment/fault_set_access.h"
#include "server/experiment/recordings.h"
#include "server/experiment/rig_access.h"
#include "server/experiment/storage_quota.h"
#include "server/experiment/work.h"
#include "server/lab/check_log.h"
#include "server/run/run_manager.h"
#include "server/run/run_quota.h"
#include "server/storage/rig_calibrations.h"

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
    RigPool& rig_pool;
    RigAccess& rigs;
    FaultSetAccess& fault_set_access;
    FaultSets& fault_sets;
    RunQuota& places;
    StorageQuota& quota;
    Benches& benches;
    RigCalibrations& calibrations;
    lab::CheckLog& checks;
    const Clock& clock;
    /// Of plans without one, for a lab of tests; none: `draw_seed`.
    std::optional<std::uint64_t> default_seed;
    /// A number that nobody can guess, below 2^53: who knows the seed of a run can play it healthy
    /// and compare, sample by sample.
    std::function<std::uint64_t()> draw_seed;
    double speed = 1.0;  ///< of replays
  };
  /// All parts must outlive it.
  explicit Experiments(Parts parts) : parts_(parts) {}

  /// Whether this rig ("": any) is a simulator, which needs no session.
  bool IsForPractice(const std::string& rig) const { return KindOn(rig) == RunKind::kSimulator; }
  /// kBusy "in_line" unless it is this person's turn for a simulator (RigAccess). What `begin`
  /// makes of it is returned; whatever it is, the place is given back, unless another one was
  /// faster.
  template <typename Begin>
  auto InTurn(const Principal& who, const ExperimentPlan& plan, Begin begin) -> decltype(begin()) {
    TRY_DONE(AwaitTurn(who, plan));
    auto begun = begin();
    if (begun.ok() || begun.error().reason != kInLine) LeaveLine(who, plan);
    return begun;
  }
  /// The body of POST runs: a plan for the bench of its rig, or the one that it names, or the usual
  /// one.
  core::Result<ExperimentPlan> Read(const boost::json::object& body);
  /// What a job does: such a body, or a diagnosis.
  core::Result<Work> ReadWork(const boost::json::object& body);
  /// As the job keeps it.
  core::Result<Work> ReadWork(std::string_view document);

  /// An experiment on a rig, or the replay of a recording. Refusals name the member of the plan by
  /// a JSON pointer; see RigAccess::Hold for those of the rig.
  core::Result<RunSnapshot> Start(const Principal& who, StartedBy by, ExperimentPlan plan);

  /// Refuses now what Start would refuse later, but for the state of the rig. The faults of a fault
  /// set stand in the plan then; whoever keeps the plan marks the set as used (Start does).
  core::Status Check(const Principal& who,
                     ExperimentPlan& plan,
                     RigPool::Like on = RigPool::Like::kSimulator);

 private:
  core::Result<const core::Bench*> BenchOf(const boost::json::object& body);
  core::Status TakeFaultSet(const Principal& who, ExperimentPlan& plan);
  static constexpr const char* kInLine = "in_line";
  /// Nothing to wait for where the plan names its rig.
  core::Status AwaitTurn(const Principal& who, const ExperimentPlan& plan);
  void LeaveLine(const Principal& who, const ExperimentPlan& plan);
  core::Result<RunRequest> OnRig(const Principal& who, StartedBy by, const ExperimentPlan& plan);
  void UseWhatWasLearnt(const Principal& who, const hardware::RigDescription& rig, RunRequest& run);
  core::Result<RunRequest> Replay(const Principal& who, StartedBy by, const ExperimentPlan& plan);
  RunKind KindOn(const std::string& rig) const;
  core::Result<std::shared_ptr<void>> PlaceFor(const Principal& who,
                                               StartedBy by,
                                               RunKind kind,
                                               std::int64_t samples);

  Parts parts_;
};

}  // namespace faultlab::server
