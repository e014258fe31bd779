#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "core/diagnosis/diagnosis.h"
#include "core/diagnosis/diagnosis_options.h"
#include "core/diagnosis/diagnosis_task.h"
#include "core/types/calibration.h"
#include "core/types/frame.h"
#include "core/types/sample.h"
#include "core/types/verdict.h"

namespace faultlab::core {

/// How far a run is with learning its healthy rig.
enum class Learning {
  kStretch,  ///< the fault-free stretch goes on: what changes the rig now spoils it
  kSolving,  ///< the stretch is over, its calibration is being worked out
  kLearnt,   ///< calibrated, here or before the run
  kGivenUp,  ///< the stretch was refused: the run has no diagnosis
};

/// The diagnosis of one run, sample by sample: six estimators, detection, verdict.
///
///   rig --Sample--> Push --Frame--> viewers, recorder
///                    |  TakeTask --DiagnosisTask--> RunTask (any thread) --DiagnosisResult-->
///                    Accept
///                    +--> verdict()
///
/// Push costs one to two microseconds and, once calibrated, allocates nothing between alarms.
/// Whatever takes longer (calibration, fits) leaves as a task; a run whose tasks nobody takes still
/// detects once it is calibrated. At most one task is out; a task not yet taken is replaced by a
/// newer one. The estimates depend on the samples alone; verdicts also on when results were
/// accepted. Not thread-safe: Push, TakeTask and Accept belong to one thread.
class Pipeline {
 public:
  explicit Pipeline(DiagnosisOptions options);
  ~Pipeline();
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;

  /// The returned frame lives until the next Push.
  const Frame& Push(const Sample& sample);

  const Verdict& verdict() const;
  /// Rises whenever verdict() changes.
  std::uint64_t verdict_version() const;

  /// Work for another thread, if there is any.
  std::optional<DiagnosisTask> TakeTask();
  void Accept(DiagnosisResult result);

  Learning learning() const;
  /// Null until known; the stored one if the config had one.
  std::shared_ptr<const Calibration> calibration() const;

  /// The diagnosis so far, with paper methods for display: a view of the run while it lasts.
  Diagnosis Snapshot() const;
  /// Solves what is still open, in place, with all data, and returns the diagnosis of the run.
  Diagnosis Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace faultlab::core
