#pragma once

#include "core/isolation/clean_readings.h"
#include "core/isolation/explanation.h"
#include "core/isolation/fit_context.h"
#include "core/isolation/isolation.h"
#include "core/isolation/isolation_task.h"

namespace faultlab::core {

/// Less than this share is the error of a known fault's value, of the calibration or of the model.
inline constexpr double kErrorShare = 0.03;

/// An explanation and what it says: the verdict, its sentence, and since when.
struct Conclusion {
  IsolationResult result;
  Explanation explanation;
  bool second = false;  ///< beside the faults that were known
  double cost = 0.0;    ///< of the best fit
  double strain = 0.0;  ///< what it pays of that because the coordinates are off their prior
};

/// What an explanation is told about.
struct ToldAbout {
  const IsolationTask& task;
  const FitContext& nominal;  ///< the calibrated rig
  const CleanReadings& readings;
  /// The faults that are known hold the motor near rest (HardlyTurns).
  bool held = false;
};

/// The answer of a task before anything is said.
IsolationResult Unanswered(const IsolationTask& task);

/// @param second  `explanation` is of a fault beside those that were known
Conclusion Told(Explanation explanation, bool second, const ToldAbout& about);

}  // namespace faultlab::core
