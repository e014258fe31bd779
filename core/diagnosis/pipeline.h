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

/// The state of the calibration of a run.
enum class Learning {
  kStretch,  ///< the fault-free stretch goes on; a change of the rig now makes the calibration
             ///< wrong
  kSolving,  ///< the stretch is over, the calibration is being computed
  kLearnt,   ///< calibrated, in this run or before it
  kGivenUp,  ///< the calibration was refused: the run has no diagnosis
};

/// The diagnosis of one run, sample by sample: six estimators, detection, verdict.
///
///   rig --Sample--> Push --Frame--> viewers, recorder
///                    |  TakeTask --DiagnosisTask--> RunTask (any thread) --DiagnosisResult-->
///                    Accept
///                    +--> verdict()
///
/// Push takes one to two microseconds and, after the calibration, allocates nothing between alarms.
/// Slower work (calibration, fits) leaves as a task. If nobody takes the tasks of a run, it still
/// detects once it is calibrated. At most one task is out; a newer task replaces one that was not
/// yet taken. The estimates depend on the samples alone; verdicts depend also on when results were
/// accepted. Not thread-safe: Push, TakeTask and Accept belong to one thread.
class Pipeline {
 public:
  explicit Pipeline(DiagnosisOptions options);
  ~Pipeline();
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;

  /// The returned frame is valid until the next Push.
  const Frame& Push(const Sample& sample);

  const Verdict& verdict() const;
  /// Increases whenever verdict() changes.
  std::uint64_t verdict_version() const;

  /// Work for another thread, if there is any.
  std::optional<DiagnosisTask> TakeTask();
  void Accept(DiagnosisResult result);

  /// Starts the diagnosis anew: the healthy stretch begins at `from_s`, not before the samples
  /// pushed so far, and is as long as the options say. What was calibrated and found is forgotten,
  /// as in the diagnosis of a record with this stretch; the estimates go on.
  void LearnAgain(double from_s);

  Learning learning() const;
  /// Null until known; the stored calibration if the options contained one.
  std::shared_ptr<const Calibration> calibration() const;

  /// The diagnosis so far, with the paper's methods for display, while the run goes on.
  Diagnosis Snapshot() const;
  /// Runs the open tasks at once with all data, and returns the diagnosis of the run.
  Diagnosis Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace faultlab::core
