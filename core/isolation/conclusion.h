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
  std::size_t beneath = 0;  ///< so many of the faults that were known it is on top of
  double cost = 0.0;        ///< of the best fit
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

/// @param beneath  of the faults that were known, those that `explanation` is on top of: the first
/// so many
Conclusion Told(Explanation explanation, std::size_t beneath, const ToldAbout& about);

}  // namespace faultlab::core
